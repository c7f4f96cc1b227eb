// Print what the Khronos validator says of a GLB: node validate.mjs NODE_MODULES FILE
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";

const [modules, file] = process.argv.slice(2);
const validator = createRequire(`${modules}/`)("gltf-validator");
const bytes = (path) => new Uint8Array(readFileSync(path));
const { issues } = await validator.validateBytes(bytes(file), {
  externalResourceFunction: async (uri) => bytes(join(dirname(file), decodeURIComponent(uri))),
});
console.log(JSON.stringify(issues));
