// Print what other programs read in a file: node avatars.mjs NODE_MODULES vrma|avatar|live2d|spine FILE SECONDS...
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";

const [modules, kind, file, ...seconds] = process.argv.slice(2);
const times = seconds.map(Number);
const require = createRequire(`${modules}/`);
const load = (name) => import(pathToFileURL(require.resolve(name)).href);

/** Contents of a glTF file, as three reads it with a plug-in. */
async function gltf(path, Plugin) {
  globalThis.self = globalThis;
  console.warn = () => {};     // of hips, which an animation of a face does not have
  const { GLTFLoader } = await load("three/addons/loaders/GLTFLoader.js");
  const loader = new GLTFLoader();
  loader.register((parser) => new Plugin(parser));
  const bytes = readFileSync(path);
  const whole = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
  return loader.parseAsync(whole, "");
}

const pixiv = (name) => import(
  pathToFileURL(`${modules}/@pixiv/${name}/lib/${name}.module.js`).href);

/** Animation in a `.vrma`, as three-vrm-animation reads it. */
async function animationOf(path) {
  const { VRMAnimationLoaderPlugin } = await pixiv("three-vrm-animation");
  return (await gltf(path, VRMAnimationLoaderPlugin)).userData.vrmAnimations[0];
}

/** Weights of the shapes of an avatar at the times, as its expressions move them by the `.vrma` beside it. */
async function avatar() {
  const { VRMExpressionLoaderPlugin } = await pixiv("three-vrm-core");
  const { scene, userData } = await gltf(file, VRMExpressionLoaderPlugin);
  const { preset, custom } = (await animationOf(file.replace(/\.vrm$/, ".vrma"))).expressionTracks;
  const played = [...preset, ...custom].map(([name, track]) => [name, track.createInterpolant()]);
  const meshes = [];
  scene.traverse((one) => one.morphTargetInfluences && meshes.push(one));
  return times.map((time) => {
    for (const [name, mixed] of played) userData.vrmExpressionManager.setValue(name, mixed.evaluate(time)[0]);
    userData.vrmExpressionManager.update();
    return [...meshes[0].morphTargetInfluences];
  });
}

/** Weights of each expression at the times, as three-vrm-animation reads them. */
async function vrma() {
  const read = await animationOf(file);
  const rows = (tracks) => Object.fromEntries([...tracks].map(([name, track]) => {
    const mixed = track.createInterpolant();
    return [name, times.map((time) => mixed.evaluate(time)[0])];
  }));
  const head = read.humanoidTracks.rotation.get("head")?.createInterpolant();
  return {
    preset: rows(read.expressionTracks.preset), custom: rows(read.expressionTracks.custom),
    head: head && times.map((time) => [...head.evaluate(time)]),
  };
}

/** Values of each parameter at the times, as the framework of Live2D in pixi-live2d-display reads them. */
async function live2d() {
  const text = readFileSync(`${modules}/pixi-live2d-display/dist/cubism4.es.js`, "utf-8")
    .replace(/^import .*$/gm, "");     // of pixi, which draws
  const stubs = "class EventEmitter {} class Matrix {} class Transform {} class Point {} class ObservablePoint {}"
    + " class Texture {} class Container {} const url = {}; const window = globalThis;";
  globalThis.Live2DCubismCore = {};
  const source = Buffer.from(`${stubs}\n${text}`).toString("base64");
  const { CubismMotion } = await import(`data:text/javascript;base64,${source}`);
  const motion = CubismMotion.create(JSON.parse(readFileSync(file, "utf-8")));
  const { _motionData: data } = motion;
  const at = (curve, time) => {
    const own = data.segments.slice(curve.baseSegmentIndex, curve.baseSegmentIndex + curve.segmentCount);
    const end = (one) => data.points[one.basePointIndex + (one.segmentType === 1 ? 3 : 1)];
    const found = own.find((one) => end(one).time > time);
    return found ? found.evaluate(data.points.slice(found.basePointIndex), time) : end(own.at(-1)).value;
  };
  const curves = data.curves.filter((curve) => curve.segmentCount);
  return {
    fps: data.fps, loop: data.loop, duration: data.duration,
    fades: [motion._fadeInSeconds, motion._fadeOutSeconds],
    segments: data.segments.length, points: data.points.length,
    values: Object.fromEntries(curves.map((curve) => [curve.id, times.map((time) => at(curve, time))])),
  };
}

/** Name of the drawing in the slot at the times, as the runtime of Spine shows it. */
async function spine() {
  const spine = await load("@esotericsoftware/spine-core");
  const atlas = { newRegionAttachment: (_, name, path) => new spine.RegionAttachment(name, path) };
  const data = new spine.SkeletonJson(atlas).readSkeletonData(readFileSync(file, "utf-8"));
  const skeleton = new spine.Skeleton(data);
  skeleton.setToSetupPose();
  const [line] = data.animations;
  const names = times.map((time) => {
    line.apply(skeleton, 0, time, false, [], 1, spine.MixBlend.setup, spine.MixDirection.mixIn);
    return skeleton.findSlot("mouth").getAttachment()?.name;
  });
  return { version: data.version, name: line.name, duration: line.duration, names };
}

console.log(JSON.stringify(await { vrma, avatar, live2d, spine }[kind]()));
