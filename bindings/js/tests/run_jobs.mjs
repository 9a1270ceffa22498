// SPDX-License-Identifier: MIT
// Runs calls of the module for test_module.py.  The file that is named on the command line holds a
// list of {call, picture, detail, how, out}; pictures are {file, kind, width, height, channels} with
// samples as they lie in memory.  Samples of the result go to `out`, the rest to standard output.
import { readFileSync, writeFileSync } from "node:fs";
import { load } from "../index.js";

const KINDS = { uint8: Uint8Array, uint16: Uint16Array, float32: Float32Array };

const read = ({ file, kind, width, height, channels }) => {
  const bytes = readFileSync(file);
  const copy = new Uint8Array(bytes).buffer;
  return { data: new KINDS[kind](copy), width, height, channels };
};

const ntp = await load();
const results = JSON.parse(readFileSync(process.argv[2], "utf8")).map((job) => {
  try {
    const pictures = [job.picture, job.detail].filter(Boolean).map(read);
    const result = ntp[job.call](...pictures, ...(job.size ?? []), job.how ?? {});
    const { data, ...rest } = ArrayBuffer.isView(result) ? { data: result } : result;
    if (data !== undefined) writeFileSync(job.out, data);
    return { ...rest, kind: data?.constructor.name };
  } catch (error) {
    if (error.name !== "NtpError") throw error;
    return { error: error.message, status: error.status };
  }
});
process.stdout.write(JSON.stringify(results));
