// Print what the Khronos validator says of a GLB: node validate.mjs NODE_MODULES FILE
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const [modules, file] = process.argv.slice(2);
const validator = createRequire(`${modules}/`)("gltf-validator");
const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(file)));
console.log(JSON.stringify(issues));
