// Counts the bytes that playing leaves behind: node --expose-gc frames.mjs MODULE ARCHIVE NAME
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [module, file, name] = process.argv.slice(2);
const { Archive, Player } = await import(pathToFileURL(module).href);
const bytes = readFileSync(file);
const archive = new Archive(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
const player = new Player(archive);
const own = new Float32Array(archive.poses.length).fill(0.3);
const out = new Float32Array(archive.poses.length);

function frames(count) {
  for (let frame = 0; frame < count; frame++) {
    if (!(frame & 127)) player.seek(0);
    player.advance(1 / 60);
    player.blend(own, frame & 1 ? "max" : "replace", own, out);
  }
}

player.play(name, 0.1);
frames(50_000);
const FRAMES = 50_000;
globalThis.gc();
const before = process.memoryUsage().heapUsed;
frames(FRAMES);
console.log((process.memoryUsage().heapUsed - before) / FRAMES);
