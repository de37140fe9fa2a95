// Bokmål. A page whose reader chose it has this before its other scripts, with the words that its own scripts say
// (`scripts/words.mjs`); those of parts that come after the map and STOP are fetched with them, those of refusals, and of parts
// that few open, when they are first needed.

import { type Packed, unpack } from "./packed.mjs";
import { Reworder } from "./reword";

/** How long the words may take to come, ms. */
const FETCH_MS = 20_000;
/** After they did not come they are asked for again this much later, and twice as much each time up to the second, ms. */
const AGAIN_MS = 5_000;
const LONGEST_MS = 80_000;

/** `soon` and `rest` are asked when their words are first needed. After that failed they are asked by themselves and at the next
 * need: until they are here these texts are English, and then said again. */
export function speak(words: Packed, soon: () => Promise<Packed>, rest: () => Promise<Packed>): void {
  const known = unpack(words);
  const reworder = new Reworder();
  const came = (): void => reworder.came();
  const [ofSoon, ofRest] = [new Later(soon, came), new Later(rest, came)];
  globalThis.lutraWords = (english) => known(english) ?? ofSoon.words(english) ?? ofRest.words(english);
  globalThis.lutraSoonWords = () => ofSoon.come();
  globalThis.lutraMoreWords = () => ofRest.come();
  globalThis.lutraMissed = (text, again) => {
    if (ofSoon.waits || ofRest.waits) reworder.missed(text, again);
  };
}

/** Words that come later, once. */
class Later {
  words: ReturnType<typeof unpack> = () => undefined;
  /** They were asked for and are not here. */
  waits = false;
  private coming: Promise<void> | undefined;
  private againMs = AGAIN_MS;

  constructor(private readonly ask: () => Promise<Packed>, private readonly came: () => void) {}

  /** It never fails. */
  come(): Promise<void> {
    if (this.coming) return this.coming;
    this.waits = true;
    this.coming = this.ask().then(
      (packed) => {
        this.words = unpack(packed);
        this.waits = false;
        this.came();
      },
      () => {
        this.coming = undefined;
        this.later();
      },
    );
    return this.coming;
  }

  private later(): void {
    setTimeout(() => void this.come(), this.againMs);
    this.againMs = Math.min(LONGEST_MS, 2 * this.againMs);
  }
}

/** Fetched as a file: a module whose loading failed fails at once when it is asked for again. */
export async function fetched(address: URL): Promise<Packed> {
  const response = await fetch(address, { signal: AbortSignal.timeout(FETCH_MS) });
  if (!response.ok) throw new Error(`${address.pathname}: ${response.status}`);
  return (await response.json()) as Packed;
}
