// Print the points of a page's face at some seconds: node points.mjs STATIC PAGE SECONDS...
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [folder, file, ...seconds] = process.argv.slice(2);
const load = (name) => import(pathToFileURL(`${folder}/${name}.js`));
const { unpack } = await load("line/unpack");
const { Take } = await load("line/take");
const { FaceShape } = await load("face/face_shape");

const html = readFileSync(file, "utf8");
const element = (id) => html.match(new RegExp(`id="${id}">([^]*?)</script>`))[1];
const data = await unpack(element("document"), element("block"));
const take = new Take(data.takes[0]), shape = new FaceShape(data.faces[take.data.face]);
console.log(JSON.stringify(seconds.map(Number).map((one) => {
  shape.move(take.channelsAt(one));
  return [...shape.points];
})));
