// Giving orders from a vessel's control: what is said of them, what went wrong, and where.

import { reason, Refusal } from "../api/http";
import type { Order, System } from "../api/types.gen";
import type { RefusedOnMap } from "../map/danger";
import { legTo } from "../state/control";
import { legsOfGoto, refusalText } from "../state/refusal";
import { make, setAttribute, setText } from "../ui/dom";
import { bearing, utc } from "../ui/format";
import { t } from "../words/words";
import { type Confirm, createConfirm } from "./confirm";
import { createOrders, type Orders, Unanswered, windowKey } from "./orders";
import { Refusals } from "./refusals";

export class Giving {
  readonly key = windowKey();
  readonly orders: Orders;
  readonly trouble = make("p", { class: "note bad", role: "alert", hidden: "" });
  readonly heard = make("p", { class: "heard", role: "status" });
  readonly confirmBox = make("div");
  readonly confirm: Confirm = createConfirm(this.confirmBox);
  readonly refusals: Refusals;
  /** The vessel, where it is known. */
  system: System | undefined;

  constructor(readonly address: number, readonly name: () => string, map: RefusedOnMap | undefined) {
    this.orders = createOrders(address, this.key);
    this.refusals = new Refusals(map);
  }

  /** Says what went wrong; empty for nothing, which also takes away where something was refused. */
  readonly fail = (text: string): void => {
    setText(this.trouble, text);
    setAttribute(this.trouble, "hidden", text ? null : "");
    if (!text) this.refusals.clear();
  };

  say(text: string): void {
    setText(this.heard, text);
  }

  async give(order: Order): Promise<void> {
    this.fail("");
    try {
      this.refusals.watch(await this.orders.give(order));
    } catch (error) {
      this.refused(error, order.kind);
    }
  }

  /** An order of this kind did not come about, for whatever reason. */
  refused(error: unknown, order: string): void {
    this.fail(saidOf(error, order));
    this.refusals.tell(error, order);
  }

  /** The way from where the vessel is to a place, in words. */
  leg(to: readonly [number, number] | null | undefined): string {
    const { system } = this;
    if (!to) return t("First leg: the plan names no place.");
    if (!system?.fix) return t("First leg unknown: vessel position unknown.");
    if (system.liveness !== "live") return t("First leg unknown: the vessel's last position is old ({time}).", { time: utc(system.fix.time_us, false) });
    const { distance_m, bearing_rad } = legTo(system.fix, to);
    return t("First leg: {bearing}, {distance} m.", { bearing: bearing(bearing_rad), distance: Math.round(distance_m) });
  }
}

/** What went wrong with an order of this kind, in words. */
export function saidOf(error: unknown, order = ""): string {
  if (error instanceof Unanswered) return error.message;
  const guard = error instanceof Refusal && order === "goto" ? error.why.guard : undefined;
  return guard && error instanceof Refusal ? refusalText({ ...error.why, guard: { ...guard, reasons: legsOfGoto(guard.reasons) } }) : reason(error);
}
