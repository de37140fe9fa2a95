// Whose a click on the map is: one listener asks all who may want it, in one order, and the first that takes it has it alone.

import type OlMap from "ol/Map";
import type MapBrowserEvent from "ol/MapBrowserEvent";

/** In this order: what somebody has in hand, then what lies there from above, then the place itself. */
const ORDER = ["edit", "pick", "measure", "vessel", "tags", "track", "place"] as const;

export type Claim = (typeof ORDER)[number];

export interface Clicks {
  /** `take` says whether the click was meant for it. A claim has one taker; the last that came. */
  claim(what: Claim, take: (event: MapBrowserEvent) => boolean): void;
}

export function createClicks(map: Pick<OlMap, "on">): Clicks {
  const takers = new Map<Claim, (event: MapBrowserEvent) => boolean>();
  map.on("singleclick", (event) => void ORDER.some((claim) => takers.get(claim)?.(event)));
  return { claim: (what, take) => void takers.set(what, take) };
}
