// Bokmål. A page whose reader chose it has this before its other scripts.

import { unpack } from "./packed.mjs";
import words from "lutra:nb";

globalThis.lutraWords = unpack(words);

export {};
