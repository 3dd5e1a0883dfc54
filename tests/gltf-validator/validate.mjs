// Validates the GLB or glTF named on the command line with the Khronos validator and prints its counts as JSON.
// Ends with status 1 if there are errors or warnings, and prints the messages.
import { readFileSync } from "node:fs";
import { validateBytes } from "gltf-validator";

const file = process.argv[2];
if (!file) {
  console.error("usage: node validate.mjs FILE");
  process.exit(2);
}
const report = await validateBytes(new Uint8Array(readFileSync(file)), { maxIssues: 100 });
const { numErrors, numWarnings, numInfos, numHints, messages } = report.issues;
console.log(JSON.stringify({ errors: numErrors, warnings: numWarnings, infos: numInfos, hints: numHints }));
if (messages.length > 0) {
  console.error(JSON.stringify(messages, null, 1));
}
process.exit(numErrors + numWarnings > 0 ? 1 : 0);
