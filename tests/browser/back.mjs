// The page's requests to a studio that ends and is started again, without a browser, as JSON:
//
//   node back.mjs STATIC
//
// `told` are the notices, `opened` is how often the pair was asked for, and `answers` are those to two requests at once.
import { pathToFileURL } from "node:url";

const TOKEN = "a-token-for-the-tests", text = new TextEncoder();
const key = await crypto.subtle.importKey("raw", text.encode(TOKEN), { name: "HMAC", hash: "SHA-256" }, false, ["sign"]);

let server = "first", dead = 0;

globalThis.location = { pathname: `/${TOKEN}/` };
globalThis.BroadcastChannel = class { postMessage() {} };
globalThis.fetch = async (path) => {
  if (dead-- > 0) throw new TypeError("Failed to fetch");
  if (path.startsWith("/proof/")) return new Response(await crypto.subtle.sign("HMAC", key, text.encode(path.slice("/proof/".length))));
  const refused = path === "api/open" && told.length < 2;
  return new Response(JSON.stringify(refused ? { error: "no pose set" } : { server }), { status: refused ? 422 : 200, headers: { "x-studio": server } });
};

const { api } = await import(pathToFileURL(`${process.argv[2]}/shell/api.js`));
const told = [];
let opened = 0;
api.lost = (why) => told.push(why);
api.back = async () => { opened++; await api.direct.post("open"); };
await api.get("state");
[server, dead] = ["second", 3]; // neither request finds a server, nor does the first look for one
const answers = await Promise.all([api.get("state"), api.get("face")]);
process.stdout.write(JSON.stringify({ told, opened, answers }));
process.exit(0);
