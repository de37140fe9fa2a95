import { keysOfAlarms, keysOfSaid, keysOfScripts, keysOfServer } from "./scripts/keys.mjs";
import { readFile } from "node:fs/promises";
const web="/work/bok/web";
const nb=JSON.parse(await readFile("/work/bok/words/nb.json","utf8"));
const all=[...keysOfScripts(web).keys,...await keysOfServer("/work/bok/server"),...await keysOfAlarms("/work/bok"),...await keysOfSaid("/work/bok")];
const asked=new Set(all.map(([k])=>k));
console.log("MISSING"); for (const k of new Set(all.filter(([k])=>!Object.hasOwn(nb,k)).map(([k])=>k))) console.log(JSON.stringify(k));
console.log("UNUSED"); for (const k of Object.keys(nb)) if(!asked.has(k)) console.log(JSON.stringify(k));
