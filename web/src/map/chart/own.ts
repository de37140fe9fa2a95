// What a vessel's own guard goes by, once it has told anybody; it is asked only where it has told nobody. One that has no such
// guard, is not heard or may not be asked has the limits of the server.

import { createReader, type Reader } from "../../params/reading";
import { type DepthLimits, ownLimits } from "../../state/chart";
import { GUARD_ENTITY } from "../../state/guard";

/** A vessel that has told is looked at again so often, ms. */
const AGAIN_MS = 60_000;
/** One that has not reported its limits yet is asked again this much later, and twice as much each time, ms. */
const OWN_AGAIN_MS = 5_000;

export class OwnLimits {
  limits: DepthLimits | undefined;
  private readonly reader: Reader;
  private timer: number | undefined;
  private soon = OWN_AGAIN_MS;
  private gone = false;

  /** `changed` is called when they are others than before. */
  constructor(vessel: number, private readonly changed: () => void) {
    this.reader = createReader(`/api/v1/vessels/${vessel}`);
    void this.learn();
  }

  dispose(): void {
    this.gone = true;
    window.clearTimeout(this.timer);
  }

  private async learn(): Promise<void> {
    const { reader, limits } = this;
    const told = await reader.known().then(async (known) => ownLimits(known) ?? ownLimits((await reader.read([GUARD_ENTITY])).told)).catch(() => undefined);
    if (told && (told.navigable_m !== limits?.navigable_m || told.autonomous_m !== limits.autonomous_m)) {
      this.limits = told;
      this.changed();
    }
    if (this.gone) return;
    this.timer = window.setTimeout(() => void this.learn(), this.limits ? AGAIN_MS : this.soon);
    this.soon = Math.min(AGAIN_MS, 2 * this.soon);
  }
}
