// Plans aboard a vessel: which they are, starting one after a second step, stopping what is sailed.

import { getJson, reason } from "../api/http";
import type { PlanAboard, PlansAboard } from "../api/types.gen";
import { asCards } from "../ui/cards";
import { make, setAttribute, setText } from "../ui/dom";
import { utc } from "../ui/format";
import { t, tn } from "../words/words";
import { type Giving, saidOf } from "./giving";

export class PlansOfVessel {
  readonly root = make("section");
  private readonly rows = make("tbody");
  private readonly table = make("table", {}, make("thead", {}, make("tr", {}, ...[t("Plan"), t("Digest"), t("Changed"), ""].map((text) => make("th", { scope: "col" }, text)))), this.rows);
  private readonly wide = make("div", { class: "wide", tabindex: "0", role: "region", "aria-label": t("Plans aboard"), hidden: "" }, this.table);
  private readonly none = make("p", { class: "empty" });
  private readonly stop = make("button", { type: "button" }, t("Stop plan"));
  private here = false;

  constructor(private readonly giving: Giving, private readonly may: boolean) {
    const refresh = make("button", { type: "button" }, t("Refresh plans aboard"));
    this.root.append(make("h3", {}, t("Plans aboard")), this.none, this.wide, make("div", { class: "row" }, ...(may ? [refresh, this.stop] : [])));
    refresh.addEventListener("click", () => {
      giving.fail("");
      giving.orders.ask({ kind: "plan.list" }).then(() => this.look(), (error: unknown) => giving.fail(t("Plans aboard: {why}", { why: saidOf(error) })));
    });
    this.stop.addEventListener("click", () => void giving.give({ kind: "plan.stop" }));
  }

  /** Asks the server what the vessel told. */
  async look(): Promise<void> {
    try {
      this.show(await getJson<PlansAboard>(`/api/v1/vessels/${this.giving.address}/plans`));
    } catch (error) {
      this.giving.fail(reason(error));
    }
  }

  /** Asks the vessel for the plan, then the person whether it shall be started. */
  async start({ plan_id: plan, md5 }: PlanAboard): Promise<void> {
    const { giving } = this;
    const name = giving.name();
    giving.fail("");
    giving.say(t("Asking {name} for the plan {plan} …", { name, plan }));
    try {
      const given = (await giving.orders.ask({ kind: "plan.get", plan_id: plan })).plan;
      giving.say("");
      const lines = [t("Vessel: {name}", { name }), given ? tn(given.maneuvers, "Plan: {plan}, {n} maneuver", "Plan: {plan}, {n} maneuvers", { plan }) : t("Plan: {plan}", { plan }), t("Digest: {md5}", { md5: given?.md5 ?? md5 }), giving.leg(given?.first_deg), t("The current plan or order will be cancelled.")];
      giving.confirm.ask(t("Start {plan} on {name}?", { plan, name }), lines, t("Start {plan}", { plan }), () => void giving.give({ kind: "plan.start", plan_id: plan }));
    } catch (error) {
      giving.say("");
      giving.fail(`${plan}: ${saidOf(error)}`);
    }
  }

  /** Whether this window has control. */
  enable(here: boolean): void {
    this.here = here;
    for (const one of [this.stop, ...this.rows.querySelectorAll("button")]) {
      one.disabled = !here;
      one.title = here ? "" : t("Take control first.");
    }
  }

  private show({ time_us, plans }: PlansAboard): void {
    setText(this.none, time_us === null ? t("Plans aboard not reported yet.") : plans.length ? t("Reported by the vessel {time}.", { time: utc(time_us) }) : t("No plan is stored aboard. Upload one first."));
    setAttribute(this.wide, "hidden", plans.length ? null : "");
    this.rows.replaceChildren(...plans.map((plan) => this.row(plan)));
    asCards(this.table);
    this.enable(this.here);
  }

  private row(plan: PlanAboard): HTMLElement {
    const go = make("button", { type: "button", "aria-label": t("Start {plan} …", { plan: plan.plan_id }) }, t("Start …"));
    go.addEventListener("click", () => void this.start(plan));
    const changed = plan.changed_us === null ? "" : `${utc(plan.changed_us)} ${plan.changed_by}`;
    return make("tr", {}, make("th", { scope: "row" }, plan.plan_id), make("td", { class: "num", title: plan.md5, "data-name": t("Digest") }, plan.md5.slice(0, 8)), make("td", { "data-name": t("Changed") }, changed), make("td", {}, ...(this.may ? [go] : [])));
  }
}
