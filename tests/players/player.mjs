// Runs steps of a file on an archive, and prints the weights after each.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [module, file, steps] = process.argv.slice(2);
const { Archive, Player } = await import(pathToFileURL(module).href);
const bytes = readFileSync(file);
let archive;
try {
  archive = new Archive(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
} catch (error) {
  console.error(error.message);
  process.exit(2);
}
if (!archive.isWhole()) throw new Error("the archive is damaged");
const player = new Player(archive);
const own = archive.poses.map(() => 0.3);
const region = archive.poses.map((_, pose) => pose % 2);
const out = archive.poses.map(() => 0);
const said = [];
for (const line of readFileSync(steps, "utf8").trim().split("\n")) {
  const [verb, what, value] = line.split(" ");
  if (verb === "play") player.play(what, Number(value));
  else if (verb === "switch") player.switch(what, Number(value));
  else if (verb === "blend") player.blend(own, what, region, out);
  else player[verb](Number(what));
  const shown = verb === "blend" ? out : [...player.weights];
  said.push([...shown, player.soundTime].map((one) => one.toFixed(6)).join(" "));
}
console.log(said.join("\n"));
