// Bokmål. A page whose reader chose it has this before its other scripts.

import words from "../../../words/nb.json";

globalThis.lutraWords = words;

export {};
