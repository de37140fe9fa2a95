// The list of systems: who is there, how fresh, where, how fast.

import type { Liveness, System } from "../api/types.gen";
import { make, setAttribute, setText } from "./dom";
import { age, bearing, knots, position, systemName } from "./format";

/** Text and shape, as colour alone tells nobody in night colours. */
const LIVENESS: Readonly<Record<Liveness, string>> = {
  live: "● live",
  late: "◐ late",
  stale: "○ stale",
  lost: "✕ lost",
};

interface Card {
  readonly root: HTMLLIElement;
  readonly button: HTMLButtonElement;
  readonly name: HTMLElement;
  readonly state: HTMLElement;
  readonly place: HTMLElement;
  readonly motion: HTMLElement;
  readonly heard: HTMLElement;
}

export interface SystemList {
  /** `linked`: whether the server is heard; without it nobody knows how anything is. */
  update(systems: readonly System[], selected: number | undefined, nowUs: number, linked: boolean): void;
}

/** Lists systems in `root`; `select` is called with the address of the one that is chosen. */
export function createList(root: HTMLElement, select: (address: number) => void): SystemList {
  const list = make("ul", { class: "systems", "aria-label": "Systems" });
  const empty = make(
    "div",
    { class: "empty" },
    make("p", {}, make("strong", {}, "No system has been heard yet.")),
    make("p", {}, "An admin names a vessel and makes a token for its link under Admin, Vessels. It appears here with its first packet."),
  );
  root.append(empty, list);
  const cards = new Map<number, Card>();

  const card = (address: number): Card => {
    const [name, state, place, motion, heard] = [span("name"), span("state"), span("num"), span("num"), span("num dim")];
    const button = make("button", { type: "button", class: "system" }, name, state, place, motion, heard);
    button.addEventListener("click", () => select(address));
    return { root: make("li", {}, button), button, name, state, place, motion, heard };
  };

  return {
    update(systems, selected, nowUs, linked) {
      setAttribute(empty, "hidden", systems.length ? "" : null);
      const here = new Set(systems.map((system) => system.address));
      for (const [address, old] of cards) {
        if (here.has(address)) continue;
        old.root.remove();
        cards.delete(address);
      }
      systems.forEach((system, index) => {
        let shown = cards.get(system.address);
        if (!shown) {
          shown = card(system.address);
          cards.set(system.address, shown);
        }
        if (list.children[index] !== shown.root) list.insertBefore(shown.root, list.children[index] ?? null);
        fill(shown, system, system.address === selected, nowUs, linked);
      });
    },
  };
}

function fill(card: Card, system: System, selected: boolean, nowUs: number, linked: boolean): void {
  setAttribute(card.button, "aria-pressed", String(selected));
  setAttribute(card.button, "data-liveness", linked ? system.liveness : "lost");
  setText(card.name, system.kind ? `${systemName(system)} · ${system.kind}` : systemName(system));
  setText(card.state, linked ? LIVENESS[system.liveness] : "? not known");
  setText(card.place, system.fix ? position(system.fix) : "no position");
  const { fix } = system;
  const motion = fix
    ? `SOG ${knots(fix.speed_mps)}  COG ${bearing(fix.course_rad)}  HDG ${bearing(fix.heading_rad)}`
    : "";
  setText(card.motion, motion);
  const heard = Math.max(0, (nowUs - system.heard_us) / 1e6);
  setText(card.heard, `heard ${age(heard)} ago${system.doors.length ? ` by ${system.doors.join(", ")}` : ""}`);
}

function span(kind: string): HTMLSpanElement {
  return make("span", { class: kind });
}
