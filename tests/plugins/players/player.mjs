// Runs the steps of a file, and prints what each shows: player.mjs MODULE STEPS
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [module, steps] = process.argv.slice(2);
const { Archive, Player, TakesError } = await import(pathToFileURL(module).href);
let player, own, region, out;

function open(path) {
  player = undefined;
  try {
    player = new Player(new Archive(new Uint8Array(readFileSync(path)).buffer));
  } catch (error) {
    if (!(error instanceof TakesError)) throw error;
    return "0";
  }
  own = player.weights.map(() => 0.3);
  region = player.weights.map((_, pose) => pose % 2);
  out = player.weights.map(() => 0);
  return "1";
}

function shown(verb, what, value) {
  if (verb === "play" || verb === "switch") player[verb](what, Number(value));
  else if (verb === "blend") player.blend(own, what, region, out);
  else player[verb](Number(what));
  const weights = verb === "blend" ? out : player.weights;
  return [...weights, player.soundTime, player.playing].map((one) => Number(one).toFixed(6)).join(" ");
}

const said = [];
for (const line of readFileSync(steps, "utf8").trim().split("\n")) {
  const [verb, what, value] = line.split(" ");
  if (verb === "open") said.push(open(what));
  else if (player) said.push(shown(verb, what, value));
}
console.log(said.join("\n"));
