// Plays every archive of a folder, and counts those refused and the lines played: MODULE FOLDER
import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [module, folder] = process.argv.slice(2);
const { Archive, Player, TakesError } = await import(pathToFileURL(module).href);
let [refused, played] = [0, 0];
for (const name of readdirSync(folder)) {
  const bytes = readFileSync(join(folder, name));
  let player;
  try {
    player = new Player(new Archive(new Uint8Array(bytes).buffer));
  } catch (error) {
    if (!(error instanceof TakesError)) throw error;
    refused++;
    continue;
  }
  for (let line = 0; line < 6; line++) {
    if (player.play(`en/${line}`, 0.1)) played++;
    for (let step = 0; step < 20; step++) player.advance(0.1);
    player.seek(0.3);
    player.switch(`en/${line}`, 0.1);
    player.skip(0.1);
  }
}
console.log(refused, played);
