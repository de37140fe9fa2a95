// The vessels beside the map: in which order, and which stay where they are while somebody is among them.

import { effect, signal } from "@preact/signals";
import { h } from "preact";
import { createMount } from "../components/mount";
import { Vessels } from "../components/vessels";
import { type Card, cardOf, inPlaces } from "../state/card";
import { inOrder, type Listed, type Order, ORDERS } from "../state/order";

export { LIVENESS } from "../state/card";

/** Where the browser keeps by what systems are sorted. */
const KEPT = "lutra-fleet-order";

interface Shown {
  readonly systems: readonly Listed[];
  readonly selected: number | undefined;
  readonly nowUs: number;
  readonly linked: boolean;
}

export interface SystemList {
  /** `linked`: whether the server is heard; without it nobody knows how anything is. */
  update(systems: readonly Listed[], selected: number | undefined, nowUs: number, linked: boolean): void;
}

/** Lists systems in `root`; `select` is called with the address of the one that is chosen. */
export function createList(root: HTMLElement, select: (address: number) => void): SystemList {
  const draw = createMount(root);
  const kept = localStorage.getItem(KEPT);
  const order = signal<Order>(ORDERS.find(([value]) => value === kept)?.[0] ?? "name");
  /** Whether the strangers are unfolded; undefined while nobody has said. */
  const unfolded = signal<boolean | undefined>(undefined);
  let shown: Shown | undefined;
  let places: readonly number[] = [];
  let sorted = "";

  const arranged = (systems: readonly Listed[]): Listed[] => {
    // Never another system under the same finger: while somebody is in the list its order stays, but for a new choice.
    const held = sorted === order.value && systems.every(({ system }) => places.includes(system.address)) && within(root);
    sorted = order.value;
    const all = inOrder(systems, order.value);
    return held ? inPlaces(all.map((one) => ({ ...one, address: one.system.address })), places) : all;
  };
  const redraw = (): void => {
    // Read in any case, so that a choice is followed by a drawing.
    const [by, open] = [order.value, unfolded.value];
    if (!shown) return;
    const { systems, selected, nowUs, linked } = shown;
    const all = arranged(systems);
    places = all.map(({ system }) => system.address);
    const cards = (ours: boolean): Card[] => all.filter((one) => one.ours === ours).map((one) => cardOf(one, nowUs, linked));
    const [mine, strangers] = [cards(true), cards(false)];
    draw(h(Vessels, {
      ours: mine,
      strangers,
      selected,
      order: by,
      open: open ?? mine.length === 0,
      select,
      sort(next) {
        localStorage.setItem(KEPT, next);
        order.value = next;
      },
      unfold: (next) => void (unfolded.value = next),
    }));
  };
  effect(redraw);

  return {
    update(systems, selected, nowUs, linked) {
      shown = { systems, selected, nowUs, linked };
      redraw();
    },
  };
}

/** Whether somebody points at a card, or has the focus on one. */
function within(root: HTMLElement): boolean {
  return [...root.querySelectorAll(".systems")].some((list) => list.matches(":hover") || list.contains(document.activeElement));
}
