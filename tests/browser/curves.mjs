// Evaluate curves in node: node curves.mjs STATIC FILE. FILE is JSON: a list of `points`, control points
// [t, v], with `times`. Printed is JSON: the values of each, `bspline` and `linear`.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [folder, file] = process.argv.slice(2);
const { valuesAt } = await import(pathToFileURL(`${folder}/curves/bspline.js`));
const asked = JSON.parse(readFileSync(file, "utf8"));
const all = (kind) => asked.map(({ points, times }) => [...valuesAt(points, kind, times)]);
console.log(JSON.stringify({ bspline: all("bspline"), linear: all("linear") }));
