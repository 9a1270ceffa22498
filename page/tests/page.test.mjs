// SPDX-License-Identifier: MIT
// All tests of the page, in one browser.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { close, errors, LIMIT, open, requests } from "./driver.mjs";

before(open, LIMIT);
after(close);

await import("./verdicts.mjs");
await import("./results.mjs");
await import("./many.mjs");
await import("./hostile.mjs");
await import("./looks.mjs");

test("nothing was sent, and nothing went wrong", LIMIT, () => {
  assert.deepEqual(requests.filter((url) => !/^(file|blob|data):/.test(url)), []);
  assert.deepEqual(errors, []);
});
