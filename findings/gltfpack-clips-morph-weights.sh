#!/usr/bin/env bash
# gltfpack 1.3.0 (meshoptimizer, MIT), seen on 2026-11-30.
#
# Behaviour: gltfpack writes animated weights of morph targets as unsigned bytes, where 255 is 1. A weight of 1.4 becomes
# 1 and one of -0.5 becomes 0, without a warning. It does so with `-noq`, too, which turns quantisation off: positions stay
# floats, weights do not. Resting weights of the mesh are kept as they are, so the model and its animation now differ.
#
# What a good engineer expects: weights of glTF have no limits, and without quantisation numbers stay what they are.
# What to do: scale targets so that all weights lie between 0 and 1, and give a target that goes both ways a second one for
# the other way. `jawRight` at -0.5, where one target moves the jaw to both sides, leaves the jaw in the middle.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init --yes > /dev/null
npm install --silent --no-audit --no-fund gltfpack@1.3.0 gltf-validator@2.0.0-dev.3.10
cat > make.mjs <<'SCRIPT'
import { writeFileSync } from "node:fs";
import validator from "gltf-validator";

// A triangle with two targets, and an animation from rest to the weights 1.4 and -0.5 in a second.
const floats = [
  [0, 0, 0, 1, 0, 0, 0, 1, 0], // positions
  [0, -1, 0, 0, 0, 0, 0, 0, 0], // the first target
  [0, 0, 0, 1, 0, 0, 0, 0, 0], // the second target
  [0, 1], // seconds
  [0, 0, 1.4, -0.5], // weights
];
const data = Buffer.from(new Float32Array(floats.flat()).buffer);
let at = 0;
const bufferViews = floats.map((values) => {
  const view = { buffer: 0, byteOffset: at, byteLength: values.length * 4 };
  at += view.byteLength;
  return view;
});
const three = (bufferView, min, max) => ({ bufferView, componentType: 5126, count: 3, type: "VEC3", min, max });
const model = JSON.stringify({
  asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ name: "face", mesh: 0 }],
  buffers: [{ byteLength: data.length, uri: `data:application/octet-stream;base64,${data.toString("base64")}` }],
  bufferViews,
  accessors: [
    three(0, [0, 0, 0], [1, 1, 0]), three(1, [0, -1, 0], [0, 0, 0]), three(2, [0, 0, 0], [1, 0, 0]),
    { bufferView: 3, componentType: 5126, count: 2, type: "SCALAR", min: [0], max: [1] },
    { bufferView: 4, componentType: 5126, count: 4, type: "SCALAR" },
  ],
  meshes: [{
    primitives: [{ attributes: { POSITION: 0 }, targets: [{ POSITION: 1 }, { POSITION: 2 }] }],
    weights: [1.4, -0.5], extras: { targetNames: ["jawOpen", "jawRight"] },
  }],
  animations: [{
    samplers: [{ input: 3, output: 4, interpolation: "LINEAR" }],
    channels: [{ sampler: 0, target: { node: 0, path: "weights" } }],
  }],
});
writeFileSync("face.gltf", model);
const { issues } = await validator.validateString(model);
console.log(`the model: ${issues.numErrors} errors, ${issues.numWarnings} warnings`);
SCRIPT
cat > show.mjs <<'SCRIPT'
import { readFileSync } from "node:fs";

const file = readFileSync(process.argv[2]);
const size = file.readUInt32LE(12);
const { accessors, animations, bufferViews, meshes } = JSON.parse(file.subarray(20, 20 + size));
const kind = ({ componentType }) => ({ 5121: "unsigned bytes", 5123: "unsigned shorts", 5126: "floats" })[componentType];
const accessor = accessors[animations[0].samplers[0].output];
const start = 28 + size + (bufferViews[accessor.bufferView].byteOffset ?? 0) + (accessor.byteOffset ?? 0);
const stride = bufferViews[accessor.bufferView].byteStride ?? 1;
const last = [2, 1].map((back) => file[start + (accessor.count - back) * stride]);
console.log(`  positions: ${kind(accessors[meshes[0].primitives[0].attributes.POSITION])}`);
console.log(`  weights at rest: ${meshes[0].weights.map((weight) => weight.toFixed(2)).join(", ")}`);
console.log(`  weights of the last key: ${kind(accessor)}, ${last.join(", ")}`);
SCRIPT
{
  node make.mjs
  for option in -kn -noq; do # names are kept; or nothing is quantised
    echo "gltfpack $option"
    npx gltfpack -i face.gltf -o face.glb $option > log 2>&1 || { cat log >&2; exit 1; }
    cat log
    node show.mjs face.glb
  done
} > seen
diff seen - <<'SEEN'
the model: 0 errors, 0 warnings
gltfpack -kn
  positions: unsigned shorts
  weights at rest: 1.40, -0.50
  weights of the last key: unsigned bytes, 255, 0
gltfpack -noq
  positions: floats
  weights at rest: 1.40, -0.50
  weights of the last key: unsigned bytes, 255, 0
SEEN
echo "as before: gltfpack keeps animated weights between 0 and 1, without quantisation, too"
