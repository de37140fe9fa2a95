// The Control tab of a vessel: who has control, plans aboard, going somewhere, what became of orders.

import type { Command, PlanAboard, PlanPlace, System } from "../api/types.gen";
import type { RefusedOnMap } from "../map/danger";
import type { ControlState, Part } from "../state/control";
import type { Guard } from "../state/guard";
import { make } from "../ui/dom";
import { t } from "../words/words";
import { PlansOfVessel } from "./aboard";
import { Giving } from "./giving";
import { GoThere } from "./gothere";
import { type CommandList, createCommandList } from "./history";
import { createLeaseView, type LeaseView } from "./lease";
import { createTeleop, type TeleopPanel } from "./teleop";

export interface ControlPanel {
  /** `guard`: what the vessel's grounding supervisor says. */
  update(state: ControlState, system: System | undefined, nowUs: number, guard?: Guard): void;
  /** Whether this window has control, so that a plan may be started. */
  holds(): boolean;
  /** Asks whether a plan that is aboard shall be started; with control only. */
  start(plan: PlanAboard): void;
  /** What was ordered elsewhere on the page: it was given, and the vessel may refuse it yet; or it was refused. */
  given(command: Command): void;
  refused(error: unknown): void;
}

export interface ControlNeeds {
  readonly address: number;
  readonly me: string;
  /** Whether the person may command this vessel. */
  readonly may: boolean;
  /** Whether it is steered by hand from here: on a page of one vessel alone, as there is one pair of hands. */
  readonly steers?: boolean;
  /** Makes a sound for who steers, if sound is on. */
  attention?(): void;
  name(): string;
  /** The next click on the map gives a place, degrees; null ends the wait. */
  pick(told: ((place: readonly [number, number]) => void) | null): void;
  /** Marks a place on the map; null for none. */
  mark(place: readonly [number, number] | null): void;
  /** Shows a route on the map while it is to be confirmed; null for none. */
  drawRoute?(places: readonly PlanPlace[] | null): void;
  /** Shows on the map where something was refused. */
  readonly refusedOnMap?: RefusedOnMap;
}

export function createControl(root: HTMLElement, needs: ControlNeeds): ControlPanel {
  return new Panel(root, needs);
}

class Panel implements ControlPanel {
  private readonly giving: Giving;
  private readonly plans: PlansOfVessel;
  private readonly goThere: GoThere;
  private readonly leaseView: LeaseView;
  private readonly past: CommandList;
  private readonly helm: TeleopPanel | undefined;
  private part: Part = "free";
  /** The last command after which the list of plans was looked at. */
  private seen = 0;

  constructor(root: HTMLElement, needs: ControlNeeds) {
    const { address, me, may, steers, name } = needs;
    const giving = new Giving(address, name, needs.refusedOnMap);
    [this.giving, this.plans, this.goThere] = [giving, new PlansOfVessel(giving, may), new GoThere(giving, needs)];
    const [leaseBox, helmBox, pastBox] = [make("section", { "aria-label": t("Who has control") }), make("section", { "aria-label": t("Steer by hand") }), make("section", {})];
    const going = may ? this.goThere.root : make("section", { "aria-label": t("Go somewhere") });
    const { trouble, refusals, confirmBox, heard, orders, confirm, key } = giving;
    root.append(make("div", { class: "control" }, leaseBox, trouble, refusals.root, confirmBox, heard, this.plans.root, going, ...(may && steers ? [helmBox] : []), pastBox));
    this.leaseView = createLeaseView(leaseBox, me, key, may, orders, confirm, giving.fail);
    this.past = createCommandList(pastBox, heard);
    this.helm = may && steers ? createTeleop(helmBox, { address, key, orders, confirm, name, attention: () => needs.attention?.() }) : undefined;
    this.enable();
    void this.plans.look();
  }

  holds(): boolean {
    return this.part === "here";
  }

  start(plan: PlanAboard): void {
    if (this.holds()) void this.plans.start(plan);
  }

  given(command: Command): void {
    this.giving.refusals.clear();
    this.giving.refusals.watch(command);
  }

  refused(error: unknown): void {
    this.giving.refusals.tell(error, "plan.upload");
  }

  update(state: ControlState, now: System | undefined, nowUs: number, guard?: Guard): void {
    const { giving, plans } = this;
    giving.system = now;
    const before = this.part;
    this.part = this.leaseView.update(state, nowUs);
    if (this.part !== before) {
      if (!this.holds()) giving.confirm.close();
      this.enable();
    }
    this.helm?.update(this.holds(), guard);
    this.past.update(state.commands);
    giving.refusals.update(state.commands);
    const stored = state.commands.find((one) => one.over && /^plan\.(upload|delete|list)$/.test(one.order));
    if (!stored || stored.id === this.seen) return;
    this.seen = stored.id;
    void plans.look();
  }

  private enable(): void {
    this.plans.enable(this.holds());
    this.goThere.enable(this.holds());
  }
}
