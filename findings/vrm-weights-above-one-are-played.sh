#!/usr/bin/env bash
# @pixiv/three-vrm 3.5.5 with three 0.187.0 (MIT), seen on 2026-11-29.
#
# Behaviour: the manager of expressions keeps a weight between 0 and 1 where a program sets it. An animation writes the
# weight itself, and nothing keeps it there: an expression of 1.4 moves its morph targets 1.4 times as far as the artist
# drew them. A binary expression of the same weight stays at 1.
#
# What a good engineer expects: the VRM 1.0 specification lets a player clamp each value outside 0 to 1, however it is set.
# What to do: write no weight above 1; a lip that goes beyond its closure cuts into the teeth.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init --yes > /dev/null
npm install --silent --no-audit --no-fund three@0.187.0 @pixiv/three-vrm@3.5.5
cat > play.mjs <<'SCRIPT'
import * as THREE from "three";
import { VRMExpression, VRMExpressionManager, VRMExpressionMorphTargetBind } from "@pixiv/three-vrm";

/** What moves the one morph target of a mesh: its influence by a weight that a program sets or an animation plays. */
function influence(weight, { played, isBinary }) {
  const mesh = new THREE.Mesh();
  mesh.morphTargetInfluences = [0];
  const expression = new VRMExpression("aa");
  expression.isBinary = isBinary;
  expression.addBind(new VRMExpressionMorphTargetBind({ primitives: [mesh], index: 0, weight: 1 }));
  const manager = new VRMExpressionManager();
  manager.registerExpression(expression);
  if (played) {
    const root = new THREE.Object3D();
    root.add(expression);
    const mixer = new THREE.AnimationMixer(root);
    const track = new THREE.NumberKeyframeTrack(`${expression.name}.weight`, [0, 1], [weight, weight]);
    mixer.clipAction(new THREE.AnimationClip("line", 1, [track])).play();
    mixer.setTime(0.5);
  } else manager.setValue("aa", weight);
  manager.update();
  return mesh.morphTargetInfluences[0].toFixed(2);
}

for (const isBinary of [false, true])
  for (const played of [false, true])
    console.log(`${isBinary ? "binary" : "smooth"}, ${played ? "played" : "set"}: 1.4 moves ${influence(1.4, { played, isBinary })}`);
SCRIPT
node play.mjs > seen
diff seen - <<'SEEN'
smooth, set: 1.4 moves 1.00
smooth, played: 1.4 moves 1.40
binary, set: 1.4 moves 1.00
binary, played: 1.4 moves 1.00
SEEN
echo "as before: an animation plays weights above 1, which the manager would not set"
