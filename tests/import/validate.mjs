// Runs Khronos' glTF validator: validate.mjs MODULE FILE... prints one line of JSON for each file, {"file", "messages"}.
// SPDX-License-Identifier: Apache-2.0
import { createRequire } from "node:module";
import { readFile } from "node:fs/promises";
import path from "node:path";

const [module, ...files] = process.argv.slice(2);
const validator = createRequire(import.meta.url)(path.resolve(module));

// Some files end the validator itself, outside of its promise: very deep JSON exhausts its stack.
let give_up;
process.on("uncaughtException", (error) => give_up(error));

for (const file of files) {
  const stopped = new Promise((_, reject) => (give_up = reject));
  const validated = validator.validateBytes(new Uint8Array(await readFile(file)), {
    uri: path.basename(file),
    maxIssues: 1000,
    externalResourceFunction: async (uri) => new Uint8Array(await readFile(path.join(path.dirname(file), decodeURIComponent(uri)))),
  });
  let messages;
  try {
    messages = (await Promise.race([validated, stopped])).issues.messages;
  } catch (error) {
    // No report: the bytes are no glTF at all, or too much for the validator.
    const code = /stack/i.test(String(error)) ? "STACK_OVERFLOW" : "UNREADABLE";
    messages = [{ code, severity: 0, message: String(error), pointer: "" }];
  }
  console.log(JSON.stringify({ file, messages }));
}
