// Bokmål. A page whose reader chose it has this before its other scripts, with the words that its own scripts say
// (`scripts/words.mjs`); those of refusals, and of parts that are loaded later, are fetched when they are first needed.

import { type Packed, unpack } from "./packed.mjs";

export function speak(words: Packed, rest: () => Promise<Packed>): void {
  const known = unpack(words);
  let more: ReturnType<typeof unpack> = () => undefined;
  let coming: Promise<void> | undefined;
  globalThis.lutraWords = (english) => known(english) ?? more(english);
  globalThis.lutraMoreWords = () =>
    (coming ??= rest().then(
      (packed) => void (more = unpack(packed)),
      // Refusals are said in English until the page is loaded again.
      () => undefined,
    ));
}
