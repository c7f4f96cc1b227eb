#!/usr/bin/env bash
# pixi-live2d-display 0.4.0 (MIT), the web player of Live2D models, seen on 2026-11-29.
#
# Behaviour: a `.model3.json` may state the fade of a motion, `"FadeInTime": 0` for none. The player takes that 0 as "not
# given", and fades the motion in for half a second. The same 0 in the `Meta` of the motion itself is taken as it is. A
# bare motion, without a model's word, fades in for a whole second.
#
# What a good engineer expects: 0 is a time, and the word of the model outranks the player's own default.
# What to do: write the fades of lip motions into the `Meta` of each `.motion3.json`; a mouth that fades in misses its
# first sounds.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init --yes > /dev/null
npm install --silent --no-audit --no-fund --legacy-peer-deps pixi-live2d-display@0.4.0
cat > play.mjs <<'SCRIPT'
import { readFileSync } from "node:fs";

// The part of Live2D's framework needs neither a canvas nor the native core, only the names of what pixi draws with.
const framework = readFileSync("node_modules/pixi-live2d-display/dist/cubism4.es.js", "utf-8").replace(/^import .*$/gm, "");
const drawing = ["EventEmitter", "Matrix", "Transform", "Point", "ObservablePoint", "Texture", "Container"]
  .map((name) => `class ${name} {}`).join(" ");
globalThis.Live2DCubismCore = {};
const source = `${drawing} const url = {}; const window = globalThis;\n${framework}`;
const { Cubism4MotionManager, CubismMotion } = await import(
  `data:text/javascript;base64,${Buffer.from(source).toString("base64")}`);

/** A motion that opens the mouth in its first tenth of a second. */
const motion = (fades) => ({
  Version: 3,
  Meta: {
    Duration: 1, Fps: 60, Loop: false, AreBeziersRestricted: true, CurveCount: 1, TotalSegmentCount: 2,
    TotalPointCount: 3, UserDataCount: 0, TotalUserDataSize: 0, ...fades,
  },
  Curves: [{ Target: "Parameter", Id: "ParamMouthOpenY", Segments: [0, 0, 0, 0.1, 1, 0, 1, 0] }],
});
const manager = Object.create(Cubism4MotionManager.prototype);
manager.groups = { idle: "Idle" };
manager.lipSyncIds = manager.eyeBlinkIds = [];
const fade = (fades, stated) => manager.createMotion(motion(fades), "Speak", { File: "a", ...stated }).getFadeInTime();

console.log(`bare motion: ${CubismMotion.create(motion({})).getFadeInTime()} s`);
console.log(`neither states a fade: ${fade({}, {})} s`);
console.log(`the model states 0: ${fade({}, { FadeInTime: 0 })} s`);
console.log(`the model states 0.1: ${fade({}, { FadeInTime: 0.1 })} s`);
console.log(`the motion states 0: ${fade({ FadeInTime: 0 }, {})} s`);
SCRIPT
node play.mjs > seen
diff seen - <<'SEEN'
bare motion: 1 s
neither states a fade: 0.5 s
the model states 0: 0.5 s
the model states 0.1: 0.1 s
the motion states 0: 0 s
SEEN
echo "as before: the player takes a model's fade of 0 as half a second"
