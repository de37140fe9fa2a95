// A catalogue of words without its keys: of each English text 32 bits say enough, and packed they weigh a third of the texts.
// `build.mjs` packs, `nb.ts` unpacks.

/** FNV-1a over UTF-16, 32 bits. */
export function keyOf(english) {
  let key = 0x811c9dc5;
  for (let at = 0; at < english.length; at++) key = Math.imul(key ^ english.charCodeAt(at), 0x01000193) >>> 0;
  return key;
}

/** `steps` from each key to the next, upwards, in base 36, and `texts` in the same order. Throws where two texts have one key. */
export function pack(catalogue) {
  const all = Object.entries(catalogue).map(([english, text]) => ({ key: keyOf(english), english, text })).sort((one, other) => one.key - other.key);
  const twice = all.find(({ key }, at) => key === all[at - 1]?.key);
  if (twice) throw new Error(`words/nb.json: another text has the key of ${JSON.stringify(twice.english)}: word one of them differently`);
  return { steps: all.map(({ key }, at) => (key - (all[at - 1]?.key ?? 0)).toString(36)).join(" "), texts: all.map(({ text }) => text) };
}

/** The text for an English one; undefined for one that was not packed. */
export function unpack({ steps, texts }) {
  const known = new Map();
  let key = 0;
  steps.split(" ").forEach((step, at) => known.set((key += parseInt(step, 36)), texts[at]));
  return (english) => known.get(keyOf(english));
}
