#!/usr/bin/env bash
# @pixiv/three-vrm-animation 3.5.5 with three 0.187.0 (MIT), seen on 2026-11-28.
#
# Behaviour: a sampler of a `.vrma` names its interpolation, as any glTF animation does. The player reads times and
# values of an expression and plays them all as lines. STEP glides from key to key. Of CUBICSPLINE it takes the tangents
# and the values of all keys in one row, so the first key stays and the mouth never opens. Nothing is said.
#
# What a good engineer expects: STEP holds, and a spline peaks at its key, as three's own animations do.
# What to do: write LINEAR samplers with as many keys as the curve needs.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init --yes > /dev/null
npm install --silent --no-audit --no-fund three@0.187.0 @pixiv/three-vrm@3.5.5 @pixiv/three-vrm-animation@3.5.5
cat > play.mjs <<'SCRIPT'
globalThis.self = globalThis;
globalThis.ProgressEvent ??= class extends Event {};
const THREE = await import("three");
const { GLTFLoader } = await import("three/examples/jsm/loaders/GLTFLoader.js");
const { VRMExpression, VRMExpressionManager } = await import("@pixiv/three-vrm");
const { VRMAnimationLoaderPlugin, createVRMAnimationClip } = await import("@pixiv/three-vrm-animation");

// The expression "aa" is 0, 1 and 0 at 0, 1 and 2 seconds; its weight is x of the translation of a node.
function animation(interpolation) {
  const parts = interpolation === "CUBICSPLINE" ? 3 : 1; // tangent, value, tangent
  const values = new Float32Array(9 * parts);
  values[(parts + (parts === 3 ? 1 : 0)) * 3] = 1;
  const data = Buffer.concat([Buffer.from(new Float32Array([0, 1, 2]).buffer), Buffer.from(values.buffer)]);
  return JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0, 1] }],
    nodes: [{ name: "hips", translation: [0, 1, 0] }, { name: "aa" }],
    buffers: [{ byteLength: data.length, uri: `data:application/octet-stream;base64,${data.toString("base64")}` }],
    bufferViews: [
      { buffer: 0, byteOffset: 0, byteLength: 12 },
      { buffer: 0, byteOffset: 12, byteLength: values.byteLength },
    ],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 3, type: "SCALAR", min: [0], max: [2] },
      { bufferView: 1, componentType: 5126, count: 3 * parts, type: "VEC3" },
    ],
    animations: [{
      samplers: [{ input: 0, output: 1, interpolation }],
      channels: [{ sampler: 0, target: { node: 1, path: "translation" } }],
    }],
    extensionsUsed: ["VRMC_vrm_animation"],
    extensions: { VRMC_vrm_animation: {
      specVersion: "1.0", humanoid: { humanBones: { hips: { node: 0 } } },
      expressions: { preset: { aa: { node: 1 } } },
    } },
  });
}

for (const kind of ["LINEAR", "STEP", "CUBICSPLINE"]) {
  const loader = new GLTFLoader();
  loader.register((parser) => new VRMAnimationLoaderPlugin(parser));
  const { userData } = await loader.parseAsync(animation(kind), "");
  const expressionManager = new VRMExpressionManager();
  expressionManager.registerExpression(new VRMExpression("aa"));
  const humanoid = { getNormalizedBoneNode: () => null, normalizedRestPose: {} };
  const vrm = { humanoid, expressionManager, meta: { metaVersion: "1" }, lookAt: null };
  const root = new THREE.Object3D();
  root.add(...expressionManager.expressions);
  const mixer = new THREE.AnimationMixer(root);
  mixer.clipAction(createVRMAnimationClip(userData.vrmAnimations[0], vrm)).play();
  const shown = [0.5, 0.9, 1.0].map((time) => {
    mixer.setTime(time);
    return expressionManager.getValue("aa").toFixed(2);
  });
  console.log(`${kind}: aa at .5, .9 and 1 s is ${shown.join(", ")}`);
}
SCRIPT
node play.mjs > seen
diff seen - <<'SEEN'
LINEAR: aa at .5, .9 and 1 s is 0.50, 0.90, 1.00
STEP: aa at .5, .9 and 1 s is 0.50, 0.90, 1.00
CUBICSPLINE: aa at .5, .9 and 1 s is 0.00, 0.00, 0.00
SEEN
echo "as before: the player of .vrma plays every curve as lines"
