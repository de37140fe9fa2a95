// Bokmål. A page whose reader chose it has this before its other scripts, with the words that its own scripts say
// (`scripts/words.mjs`); those of refusals, and of parts that are loaded later, are fetched when they are first needed.

import { type Packed, unpack } from "./packed.mjs";

/** How long the words may take to come, ms. */
const FETCH_MS = 20_000;

/** `rest` is asked when its words are first needed, and again after it failed: until it is here, these texts are English. */
export function speak(words: Packed, rest: () => Promise<Packed>): void {
  const known = unpack(words);
  let more: ReturnType<typeof unpack> = () => undefined;
  let coming: Promise<void> | undefined;
  globalThis.lutraWords = (english) => known(english) ?? more(english);
  globalThis.lutraMoreWords = () =>
    (coming ??= rest().then(
      (packed) => void (more = unpack(packed)),
      () => void (coming = undefined),
    ));
}

/** Fetched as a file: a module whose loading failed fails at once when it is asked for again. */
export async function fetched(address: URL): Promise<Packed> {
  const response = await fetch(address, { signal: AbortSignal.timeout(FETCH_MS) });
  if (!response.ok) throw new Error(`${address.pathname}: ${response.status}`);
  return (await response.json()) as Packed;
}
