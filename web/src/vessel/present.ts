// What a vessel's page knows of the present, from the live socket.

import type { Detection, LiveFrame, System } from "../api/types.gen";
import { NO_CONTROL, withControl } from "../state/control";
import { EMPTY, type FleetState, serverNowUs } from "../state/fleet";
import type { Labels, Values } from "../state/vitals";
import { hexAddress, systemName } from "../ui/format";

const NOTHING: Values = new Map();

export class PagePresent {
  fleet: FleetState = EMPTY;
  control = NO_CONTROL;
  /** Whether the server is heard. */
  linked = true;
  system: System | undefined;
  labels: Labels = new Map();
  /** The newest detection that came by itself. */
  heard: Detection | undefined;

  /** `given`: the name that people gave it; null for none. */
  constructor(readonly address: number, readonly given: string | null) {}

  /** What the vessel is called. */
  get name(): string {
    return this.system ? systemName(this.system) : (this.given ?? hexAddress(this.address));
  }

  get values(): Values {
    return this.fleet.values.get(this.address) ?? NOTHING;
  }

  /** Whether the vessel was heard just now. */
  get isHeard(): boolean {
    return this.linked && (this.system?.liveness === "live" || this.system?.liveness === "late");
  }

  /** By the server's clock as soon as it is known, µs since 1970 UTC. */
  nowUs(): number {
    return this.fleet.serverUs ? serverNowUs(this.fleet, performance.now()) : Date.now() * 1_000;
  }

  frame(fleet: FleetState, frame: LiveFrame): void {
    this.linked = true;
    this.fleet = fleet;
    this.control = withControl(this.control, frame, this.address);
    for (const one of frame.detections) if (one.system === this.address && one.time_us >= (this.heard?.time_us ?? 0)) this.heard = one;
    const found = fleet.systems.get(this.address);
    this.system = found ? { ...found, name: this.given ?? found.name } : undefined;
    this.labels = new Map(Object.entries(this.system?.entities ?? {}).map(([number, label]) => [Number(number), label ?? ""]));
  }
}
