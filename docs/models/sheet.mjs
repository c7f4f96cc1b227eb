// Draw every morph target of a model on one sheet, to look at them side by side:
//
//     node docs/models/sheet.mjs MODEL.glb OUT.png [--focus x,y,z,radius] [--poses POSES]
//                                [--turn=yaw,pitch] [--columns N] [--size PIXELS]
//
// --focus    what the lower picture of each pose shows (in metres); without it, what moves most
// --poses    poses to draw instead of each target by itself, such as
//            "neutral; open=0.5, W=0.8; PBM" (a pose without a number is drawn in full)
// --turn     where the camera stands, in degrees to the right and upwards (14,4); with a number
//            below zero write --turn=-30,0
// --columns  poses in a row (at most 5)
// --size     width of one pose (240)
//
// It needs Chromium (the environment variable CHROMIUM, or /usr/bin/chromium) and, in the current
// folder, `npm install three playwright-core`.

import { createServer } from 'node:http';
import { existsSync } from 'node:fs';
import { readFile, writeFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseArgs } from 'node:util';

const HERE = path.dirname(fileURLToPath(import.meta.url));
const MODULES = path.resolve('node_modules');
const FLAGS = [
  '--headless', '--no-sandbox', '--disable-gpu', '--use-gl=angle', '--use-angle=swiftshader',
  '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync',
];
const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.glb': 'model/gltf-binary' };

function fail(message) {
  console.error(message);
  process.exit(1);
}

function numbers(text, count, option) {
  const values = text.split(',').map(Number);
  if (values.length !== count || values.some(Number.isNaN)) {
    fail(`${option} takes ${count} numbers with commas between, not "${text}"`);
  }
  return values;
}

/** "neutral; open=0.5, W" as [{}, {open: 0.5, W: 1}]. */
function readPoses(text) {
  return text.split(';').map((pose) => {
    const weights = {};
    for (const part of pose.split(',').map((p) => p.trim()).filter((p) => p && p !== 'neutral')) {
      const [name, weight = '1'] = part.split('=').map((p) => p.trim());
      if (Number.isNaN(Number(weight))) fail(`--poses: "${part}" has no number after "="`);
      weights[name] = Number(weight);
    }
    return weights;
  });
}

function readOptions() {
  const text = { type: 'string' };
  const options = {
    focus: text, poses: text, columns: text,
    turn: { ...text, default: '14,4' }, size: { ...text, default: '240' },
  };
  let values, positionals;
  try {
    ({ values, positionals } = parseArgs({ allowPositionals: true, options }));
  } catch (error) {
    fail(error.message);
  }
  if (positionals.length !== 2) fail('usage: node docs/models/sheet.mjs MODEL.glb OUT.png [options]');
  const draw = { turn: numbers(values.turn, 2, '--turn'), size: numbers(values.size, 1, '--size')[0] };
  if (values.focus) draw.focus = numbers(values.focus, 4, '--focus');
  if (values.columns) [draw.columns] = numbers(values.columns, 1, '--columns');
  if (values.poses) draw.poses = readPoses(values.poses);
  return { model: positionals[0], out: positionals[1], draw };
}

/** Serve the page, the model and the modules to this computer only. */
async function serve(model) {
  const server = createServer(async (request, response) => {
    const { pathname } = new URL(request.url, 'http://localhost');
    let file = pathname === '/model.glb' ? model : path.join(HERE, 'sheet.html');
    if (pathname.startsWith('/modules/')) file = path.join(MODULES, path.normalize(pathname.slice(8)));
    try {
      const body = await readFile(file);
      response.writeHead(200, { 'content-type': TYPES[path.extname(file)] ?? 'text/plain' }).end(body);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((ready) => server.listen(0, '127.0.0.1', ready));
  return server;
}

async function main() {
  const { model, out, draw } = readOptions();
  if (['three', 'playwright-core'].some((name) => !existsSync(path.join(MODULES, name)))) {
    fail(`three and playwright-core are not in ${MODULES}; run: npm install three playwright-core`);
  }
  const executablePath = process.env.CHROMIUM ?? '/usr/bin/chromium';
  if (!existsSync(executablePath)) fail(`no Chromium at ${executablePath}; set CHROMIUM to its path`);
  if (!existsSync(model)) fail(`no model at ${model}`);

  const { chromium } = createRequire(path.join(MODULES, 'here.js'))('playwright-core');
  const server = await serve(path.resolve(model));
  const browser = await chromium.launch({ executablePath, args: FLAGS });
  try {
    const page = await browser.newPage();
    page.on('pageerror', (error) => console.error(error.message));
    page.on('console', (line) => line.type() === 'error' && console.error(line.text()));
    await page.goto(`http://127.0.0.1:${server.address().port}/`);
    await page.waitForFunction(() => window.drawSheet);
    const picture = await page.evaluate((options) => window.drawSheet(options), draw);
    await writeFile(out, Buffer.from(picture.split(',')[1], 'base64'));
  } catch (error) {
    console.error(error.message);
    process.exitCode = 1;
  } finally {
    await browser.close();
    server.close();
  }
}

await main();
