// SPDX-License-Identifier: MIT
// Files in memory for the program.  Those that it writes grow by doubling: the files of
// browser_wasi_shim are copied whole at each write.
import { Directory, File, OpenFile, PreopenDirectory } from "@bjorn3/browser_wasi_shim";
import type { Files } from "./messages.js";

const SUCCESS = 0;
const FIRST_SIZE = 1 << 16;

class OpenGrowingFile extends OpenFile {
  override fd_write(data: Uint8Array) {
    const end = Number(this.file_pos) + data.byteLength;
    if (end > this.file.data.byteLength) this.#grow(end);
    this.file.data.set(data, Number(this.file_pos));
    this.file_pos = BigInt(end);
    return { ret: SUCCESS, nwritten: data.byteLength };
  }

  #grow(end: number) {
    const old = this.file.data;
    let buffer = old.buffer;
    if (old.byteOffset !== 0 || buffer.byteLength < end) {
      buffer = new ArrayBuffer(Math.max(end, 2 * old.byteLength, FIRST_SIZE));
      new Uint8Array(buffer).set(old);
    }
    this.file.data = new Uint8Array(buffer, 0, end);
  }
}

class GrowingFile extends File {
  override path_open(oflags: number, rights: bigint, flags: number) {
    const opened = super.path_open(oflags, rights, flags);
    return opened.fd_obj === null ? opened : { ret: opened.ret, fd_obj: new OpenGrowingFile(this) };
  }
}

class GrowingDirectory extends Directory {
  override create_entry_for_path(path: string, isDirectory: boolean) {
    const made = super.create_entry_for_path(path, isDirectory);
    if (made.entry === null || isDirectory) return made;
    const entry = new GrowingFile(new Uint8Array(0));
    this.contents.set(path, entry);
    return { ret: made.ret, entry };
  }
}

/** The directory in which the program runs. */
export class Folder extends PreopenDirectory {
  private constructor(files: [string, File][]) {
    super("/", new Map());
    this.dir = new GrowingDirectory(new Map(files));
  }

  static async of(files: Files): Promise<Folder> {
    const read = async ([name, blob]: [string, Blob]): Promise<[string, File]> => {
      return [name, new File(new Uint8Array(await blob.arrayBuffer()), { readonly: true })];
    };
    return new Folder(await Promise.all([...files].map(read)));
  }

  /** The files that were written. */
  made(): Files {
    const files: Files = new Map();
    for (const [name, entry] of this.dir.contents)
      if (entry instanceof GrowingFile) files.set(name, new Blob([entry.data as BlobPart]));
    return files;
  }

  /** The bytes of all files. */
  size(): number {
    let sum = 0;
    for (const entry of this.dir.contents.values()) if (entry instanceof File) sum += entry.data.byteLength;
    return sum;
  }
}
