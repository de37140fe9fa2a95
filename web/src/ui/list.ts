// The list of systems: who is there, how fresh, where, how fast.

import type { Liveness } from "../api/types.gen";
import { type Priority, SHAPES } from "../state/alarms";
import { inOrder, type Listed, type Order, ORDERS } from "../state/order";
import { make, setAttribute, setText } from "./dom";
import { age, bearing, knots, modeText, position, systemName } from "./format";

/** Where the browser keeps by what systems are sorted. */
const KEPT = "lutra-fleet-order";

/** Text and shape, as colour alone tells nobody in night colours. */
export const LIVENESS: Readonly<Record<Liveness, string>> = {
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
  readonly doing: HTMLElement;
  readonly battery: HTMLElement;
  readonly worst: HTMLElement;
  readonly heard: HTMLElement;
  readonly more: HTMLAnchorElement;
}

export interface SystemList {
  /** `linked`: whether the server is heard; without it nobody knows how anything is. */
  update(systems: readonly Listed[], selected: number | undefined, nowUs: number, linked: boolean): void;
}

/** Lists systems in `root`; `select` is called with the address of the one that is chosen. */
export function createList(root: HTMLElement, select: (address: number) => void): SystemList {
  const list = make("ul", { class: "systems", "aria-label": "Systems" });
  const empty = firstSteps();
  const order = make("select", {}, ...ORDERS.map(([value, text]) => make("option", { value }, text)));
  const head = make("div", { class: "list-head" }, make("label", {}, "Sort by ", order));
  root.append(head, empty, list);
  order.value = localStorage.getItem(KEPT) ?? "name";
  if (order.selectedIndex < 0) order.value = "name";
  let sorted = "";
  order.addEventListener("change", () => {
    localStorage.setItem(KEPT, order.value);
    sorted = "";
  });
  const cards = new Map<number, Card>();

  const card = (address: number): Card => {
    const [name, state, place, motion] = [span("name"), span("state"), span("num"), span("num")];
    const [doing, battery, worst, heard] = [span("doing"), span("battery"), span("worst"), span("num dim")];
    place.classList.add("place");
    motion.classList.add("motion");
    heard.classList.add("heard");
    // The colour that the vessel and its track have on the map.
    const button = make("button", { type: "button", class: "system", "data-series": String(address % 4) }, name, state, place, motion, doing, battery, worst, heard);
    button.addEventListener("click", () => select(address));
    const more = make("a", { class: "more", href: `/vessels/${address}` }, "Open");
    return { root: make("li", {}, button, more), button, name, state, place, motion, doing, battery, worst, heard, more };
  };

  return {
    update(systems, selected, nowUs, linked) {
      setAttribute(empty, "hidden", systems.length ? "" : null);
      const here = new Set(systems.map(({ system }) => system.address));
      for (const [address, old] of cards) {
        if (here.has(address)) continue;
        old.root.remove();
        cards.delete(address);
      }
      setAttribute(head, "hidden", systems.length > 1 ? null : "");
      // Never another system under the same finger: while somebody is in the list its order stays, but for a new choice.
      const held = sorted === order.value && systems.every(({ system }) => cards.has(system.address)) && (list.matches(":hover") || list.contains(document.activeElement));
      sorted = order.value;
      const places = new Map([...list.children].map((child, index) => [child, index]));
      const place = ({ system }: Listed): number => places.get(cards.get(system.address)?.root as Element) ?? Infinity;
      const all = held ? [...systems].sort((one, other) => place(one) - place(other)) : inOrder(systems, order.value as Order);
      all.forEach((listed, index) => {
        const { system } = listed;
        let shown = cards.get(system.address);
        if (!shown) {
          shown = card(system.address);
          cards.set(system.address, shown);
        }
        if (list.children[index] !== shown.root) list.insertBefore(shown.root, list.children[index] ?? null);
        fill(shown, listed, system.address === selected, nowUs, linked);
      });
    },
  };
}

function fill(card: Card, { system, placeIsOld, vitals, parts, alarm }: Listed, selected: boolean, nowUs: number, linked: boolean): void {
  setAttribute(card.button, "aria-pressed", String(selected));
  setAttribute(card.button, "data-liveness", linked ? system.liveness : "lost");
  setText(card.name, system.kind ? `${systemName(system)} · ${system.kind}` : systemName(system));
  setText(card.state, linked ? LIVENESS[system.liveness] : "? not known");
  setText(card.place, system.fix ? `${position(system.fix)}${placeIsOld ? " (old)" : ""}` : "no position");
  setAttribute(card.place, "data-old", placeIsOld ? "" : null);
  setAttribute(card.motion, "data-old", placeIsOld ? "" : null);
  const { fix } = system;
  const motion = fix
    ? `SOG ${knots(fix.speed_mps)}  COG ${bearing(fix.course_rad)}  HDG ${bearing(fix.heading_rad)}`
    : "";
  setText(card.motion, motion);
  setText(card.doing, doing(vitals));
  const { mode, battery } = vitals;
  setText(card.battery, battery.value === null ? "battery not reported" : `battery ${battery.value.toFixed(0)} %${battery.old ? " (old)" : ""}`);
  setAttribute(card.battery, "data-old", battery.old ? "" : null);
  setAttribute(card.doing, "data-old", mode.old ? "" : null);
  const said = alarm ? `${SHAPES[alarm.priority as Priority] ?? ""} ${alarm.priority}: ${alarm.text}` : "";
  setAttribute(card.worst, "data-quiet", said || parts.bad ? null : "");
  setText(card.worst, said || `${parts.bad ? "▲ " : ""}${parts.text}`);
  setAttribute(card.more, "aria-label", `Open ${systemName(system)}`);
  const heard = Math.max(0, (nowUs - system.heard_us) / 1e6);
  if (!system.heard_us) {
    setText(card.state, linked ? "○ not heard" : "? not known");
    setText(card.heard, "not heard since the server started");
  } else setText(card.heard, `heard ${age(heard)} ago${system.doors.length ? ` by ${system.doors.join(", ")}` : ""}`);
}

/** What a vessel does: its plan and how far it is, or how it operates. */
function doing({ mode, plan, progress }: Listed["vitals"]): string {
  const state = mode.ageS === null ? "state not reported" : `${modeText(mode.word)}${mode.old ? " (old)" : ""}`;
  if (plan.ageS === null) return `${state} · plan not reported`;
  const old = plan.old ? " (old)" : "";
  if (!plan.note) return `${state} · no plan${old}`;
  if (!/^EXECUTING$/i.test(plan.word)) return `${state} · plan ${plan.note} ${plan.word.toLowerCase()}${old}`;
  const share = progress.value === null ? "" : ` · ${progress.value.toFixed(0)} %`;
  return mode.word === "MANEUVER" && !mode.old ? `${state} ${plan.note}${share}${old}` : `${state} · executing ${plan.note}${share}${old}`;
}

/** How the first vessel comes in, by each of the ways. */
function firstSteps(): HTMLElement {
  const lines = (...all: readonly string[]): HTMLElement => make("pre", { class: "lines", tabindex: "0" }, all.join("\n"));
  const url = `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/link`;
  return make(
    "div",
    { class: "empty" },
    make("p", {}, make("strong", {}, "No system has been heard yet."), " A vessel appears here with its first packet."),
    make("h3", {}, "A vessel with lutra-agent, by its link"),
    make("p", {}, "An admin names it and makes its link token under ", make("a", { href: "/admin/vessels" }, "Admin, Vessels"), ". The token goes into a file aboard, and its place into the vessel's configuration:"),
    lines("[Transports.Lutra]", "Enabled = Always", `URL = ${url}`, "Token File = lutra.token"),
    make("h3", {}, "A vessel with DUNE in the same network, by UDP"),
    make("p", {}, "In the server's configuration, then restart the server:"),
    lines("[doors.udp]", 'listen = "0.0.0.0:6001"'),
    make("p", {}, "Aboard, [Transports.Announce] and [Transports.UDP] are enabled: both find each other by their announcements."),
    make("h3", {}, "A vessel with DUNE behind a VPN, by TCP"),
    make("p", {}, "In the server's configuration, with the vessel's address:"),
    lines("[doors.tcp]", 'connect = ["10.77.0.10:7001"]'),
    make("p", {}, "Aboard:"),
    lines("[Transports.TCP.Server]", "Enabled = Always", "Port = 7001"),
    make("p", {}, "UDP and TCP have no passwords: open them on a VPN or a network of your own only. ", make("a", { href: "/admin/doors" }, "Admin, Connections"), " tells who came in and whom the server refused."),
  );
}

function span(kind: string): HTMLSpanElement {
  return make("span", { class: kind });
}
