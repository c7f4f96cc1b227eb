// Print the samples of a page, and what it tells of some frames: node explain.mjs STATIC PAGE FRAME...
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [folder, file, ...frames] = process.argv.slice(2);
const load = (name) => import(pathToFileURL(`${folder}/${name}.js`));
const { unpack } = await load("line/unpack");
const { Take } = await load("line/take");

const html = readFileSync(file, "utf8");
const element = (id) => html.match(new RegExp(`id="${id}">([^]*?)</script>`))[1];
const data = await unpack(element("document"), element("block"));
const take = new Take(data.takes[0]);
console.log(JSON.stringify({
  sound: [...data.sound.samples],
  frames: frames.map(Number).map((frame) => ({
    ...take.soundAt(frame),
    bigrams: take.bigramsAt(frame),
    poses: Object.fromEntries(take.poses.map((pose, n) => [pose, take.stepsAt(n, frame).filter((one) => one.why)])),
  })),
}));
