#!/usr/bin/env bash
# assimpjs 0.0.10 (MIT; Assimp, BSD, as WebAssembly), seen on 2026-11-30.
#
# Behaviour: a glTF model that goes through Assimp to glTF loses its face. Corners that triangles share become points of
# their own in the mesh, but not in its targets: six points have targets of four values. The fourth is the difference of two
# points that no longer belong together, so a target that moves nothing moves that point by the width of the face. The names
# of the targets are gone, and the animation is there by name, with no channel. The conversion reports success.
#
# What a good engineer expects: the same mouth under the same names, or an error; Assimp reads and writes morph targets.
# What to do: convert faces by a tool that is made for glTF, and let a validator judge what comes out.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init --yes > /dev/null
npm install --silent --no-audit --no-fund assimpjs@0.0.10 gltf-validator@2.0.0-dev.3.10
cat > convert.mjs <<'SCRIPT'
import assimpjs from "assimpjs";
import validator from "gltf-validator";

// A square of two triangles, a target that moves nothing, one that lowers the first point, and an animation of both.
const floats = [
  [0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0], // positions
  [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], // the target "rest"
  [0, -1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], // the target "open"
  [0, 1], // seconds
  [0, 0, 0, 1], // weights
];
const corners = Buffer.from(new Uint16Array([0, 1, 2, 0, 2, 3]).buffer);
const data = Buffer.concat([Buffer.from(new Float32Array(floats.flat()).buffer), corners]);
let at = 0;
const bufferViews = [...floats.map((values) => values.length * 4), corners.length].map((byteLength) => {
  const view = { buffer: 0, byteOffset: at, byteLength };
  at += byteLength;
  return view;
});
const points = (bufferView, min, max) => ({ bufferView, componentType: 5126, count: 4, type: "VEC3", min, max });
const model = JSON.stringify({
  asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ name: "face", mesh: 0 }],
  buffers: [{ byteLength: data.length, uri: `data:application/octet-stream;base64,${data.toString("base64")}` }],
  bufferViews,
  accessors: [
    points(0, [0, 0, 0], [1, 1, 0]), points(1, [0, 0, 0], [0, 0, 0]), points(2, [0, -1, 0], [0, 0, 0]),
    { bufferView: 3, componentType: 5126, count: 2, type: "SCALAR", min: [0], max: [1] },
    { bufferView: 4, componentType: 5126, count: 4, type: "SCALAR" },
    { bufferView: 5, componentType: 5123, count: 6, type: "SCALAR" },
  ],
  meshes: [{
    primitives: [{ attributes: { POSITION: 0 }, indices: 5, targets: [{ POSITION: 1 }, { POSITION: 2 }] }],
    weights: [0, 0], extras: { targetNames: ["rest", "open"] },
  }],
  animations: [{
    name: "line", samplers: [{ input: 3, output: 4, interpolation: "LINEAR" }],
    channels: [{ sampler: 0, target: { node: 0, path: "weights" } }],
  }],
});

const assimp = await assimpjs();
const files = new assimp.FileList();
files.AddFile("face.gltf", new TextEncoder().encode(model));
const result = assimp.ConvertFileList(files, "glb2");
const glb = Buffer.from(result.GetFile(0).GetContent());
const size = glb.readUInt32LE(12);
const after = JSON.parse(glb.subarray(20, 20 + size));
const values = (index) => {
  const { bufferView, byteOffset = 0, count } = after.accessors[index];
  const start = 28 + size + (after.bufferViews[bufferView].byteOffset ?? 0) + byteOffset;
  const number = (place) => glb.readFloatLE(start + place * 4) + 0;
  return Array.from({ length: count }, (_, point) => `(${[0, 1, 2].map((axis) => number(point * 3 + axis))})`).join(" ");
};
const before = await validator.validateString(model);
console.log(`before: ${before.issues.numErrors} errors`);
console.log(`converted: ${result.IsSuccess()}`);
const [mesh] = after.meshes;
console.log(`points: ${values(mesh.primitives[0].attributes.POSITION)}`);
mesh.primitives[0].targets.forEach(({ POSITION }, index) => console.log(`target ${index}: ${values(POSITION)}`));
console.log(`names: ${mesh.extras?.targetNames ?? "none"}`);
console.log(`animations: ${after.animations.map(({ name, channels }) => `${name} with ${channels.length} channels`)}`);
const judged = await validator.validateBytes(new Uint8Array(glb));
const codes = judged.issues.messages.filter(({ severity }) => severity === 0).map(({ code }) => code);
console.log(`after: ${[...new Set(codes)].sort().join(" ")}`);
SCRIPT
node convert.mjs > seen
diff seen - <<'SEEN'
before: 0 errors
converted: true
points: (0,0,0) (1,0,0) (1,1,0) (0,0,0) (1,1,0) (0,1,0)
target 0: (0,0,0) (0,0,0) (0,0,0) (0,1,0)
target 1: (0,-1,0) (0,0,0) (0,0,0) (0,1,0)
names: none
animations: line with 0 channels
after: EMPTY_ENTITY MESH_PRIMITIVE_MORPH_TARGET_INVALID_ATTRIBUTE_COUNT
SEEN
echo "as before: a face that goes through Assimp has other targets, no names and a still animation"
