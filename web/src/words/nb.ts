// Bokmål. A page whose reader chose it has this before its other scripts, with the words that its own scripts say
// (`scripts/words.mjs`); the words of refusals are fetched when something is first refused.

import { type Packed, unpack } from "./packed.mjs";

export function speak(words: Packed, refusals: () => Promise<Packed>): void {
  const known = unpack(words);
  let more: ReturnType<typeof unpack> = () => undefined;
  let coming: Promise<void> | undefined;
  globalThis.lutraWords = (english) => known(english) ?? more(english);
  globalThis.lutraMoreWords = () =>
    (coming ??= refusals().then(
      (packed) => void (more = unpack(packed)),
      // Asked again with the next refusal; this one is said in English.
      () => void (coming = undefined),
    ));
}
