// The depth under the pointer: one question at a time, always for where the pointer is by then.

import type OlMap from "ol/Map";
import { toLonLat } from "ol/proj";
import { chartAt, depthWords } from "./api";

/** It is asked for at most so often, ms. */
const DEPTH_MS = 120;

export class DepthUnderPointer {
  private wanted: number[] | undefined;
  private asking = false;
  private pointed = false;

  /** `there`: whether there is a chart; `tell` shows the words, empty for none. */
  constructor(map: OlMap, private readonly vessel: number | undefined, there: () => boolean, private readonly tell: (words: string) => void) {
    map.on("pointermove", (event) => {
      if (!there() || event.dragging) return;
      this.pointed = true;
      this.wanted = event.coordinate;
      void this.follow();
    });
    map.getViewport()?.addEventListener("pointerleave", () => {
      this.pointed = false;
      this.wanted = undefined;
      tell("");
    });
  }

  private async follow(): Promise<void> {
    if (this.asking) return;
    this.asking = true;
    while (this.wanted) {
      const place = this.wanted;
      this.wanted = undefined;
      const [lon = 0, lat = 0] = toLonLat(place);
      try {
        const answer = await chartAt(lat, lon, 0, this.vessel);
        if (this.pointed) this.tell(depthWords(answer.depth));
      } catch {
        this.tell("");
      }
      await new Promise((done) => setTimeout(done, DEPTH_MS));
    }
    this.asking = false;
  }
}
