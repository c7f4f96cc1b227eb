// Play the last animation of a GLB in three.js, in a headless browser, and print what moved:
//
//   node play.mjs NODE_MODULES CHROMIUM FILE TIMES [FOLDER]
//
// TIMES is a JSON list of seconds. Printed is a JSON list with, for each time, the object's name ->
// {weights: {shape: weight}, turn: [x, y, z, w], place: [x, y, z]}. A FOLDER gets a picture of each.
import { readFileSync } from "node:fs";
import { dirname, join, normalize } from "node:path";
import { WEBGL, launch, serve } from "./browsing.mjs";

const [modules, chromium, file, times, folder] = process.argv.slice(2);

const PAGE = `<!DOCTYPE html>
<link rel="icon" href="data:,"><style>body { margin: 0 }</style>
<script type="importmap">
  {"imports": {"three": "/three/build/three.module.js", "three/": "/three/"}}
</script>
<script type="module">
  import * as THREE from "three";
  import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";

  const gltf = await new GLTFLoader().loadAsync("/model.glb");
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0xdddddd);
  scene.add(gltf.scene, new THREE.HemisphereLight(0xffffff, 0x666666, 3));
  const sun = new THREE.DirectionalLight(0xffffff, 2);
  sun.position.set(1, 1, 2);
  scene.add(sun);

  const size = 512;
  const box = new THREE.Box3().setFromObject(gltf.scene);
  const centre = box.getCenter(new THREE.Vector3());
  const reach = box.getSize(new THREE.Vector3()).length();
  const camera = new THREE.PerspectiveCamera(30, 1, reach / 100, reach * 10);
  camera.position.copy(centre).add(new THREE.Vector3(0.3, 0, 1.6).multiplyScalar(reach));
  camera.lookAt(centre);

  const mixer = new THREE.AnimationMixer(gltf.scene);
  const action = mixer.clipAction(gltf.animations.at(-1));
  action.setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;

  window.showAt = (seconds) => {
    action.reset().play();
    mixer.setTime(seconds);
    const state = {};
    gltf.scene.traverse((one) => {
      const weights = Object.entries(one.morphTargetDictionary ?? {}).map(
        ([name, index]) => [name, one.morphTargetInfluences[index]],
      );
      const turn = one.quaternion.toArray();
      const place = one.position.toArray();
      state[one.name] = { weights: Object.fromEntries(weights), turn, place };
    });
    return state;
  };

  let renderer;
  window.draw = () => {
    if (!renderer) {
      renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
      renderer.setSize(size, size);
      document.body.append(renderer.domElement);
    }
    renderer.render(scene, camera);
  };
  window.ready = true;
</script>`;

const KNOWN = { "/": () => PAGE, "/model.glb": () => readFileSync(file) };

const beside = (path) => readFileSync(join(dirname(file), decodeURIComponent(path)));
const find = (path) => (path.endsWith(".bin") ? beside(path) : readFileSync(join(modules, normalize(path))));
const server = await serve((path) => KNOWN[path]?.() ?? find(path));
const browser = await launch(modules, chromium, ...WEBGL);
try {
  const page = await browser.newPage({ viewport: { width: 512, height: 512 } });
  page.on("pageerror", (error) => console.error(String(error)));
  page.on("console", (said) => said.type() === "error" && console.error(said.text()));
  await page.goto(server.address);
  await page.waitForFunction(() => window.ready, null, { timeout: 60000 });
  const states = [];
  for (const [number, seconds] of JSON.parse(times).entries()) {
    states.push(await page.evaluate((at) => window.showAt(at), seconds));
    if (folder) {
      await page.evaluate(() => window.draw());
      await page.screenshot({ path: join(folder, `${number}.png`) });
    }
  }
  console.log(JSON.stringify(states));
} finally {
  await browser.close();
  server.close();
}
