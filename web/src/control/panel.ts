// The Control tab of a vessel: who has control, plans aboard, going somewhere, what became of orders.

import { getJson, reason } from "../api/http";
import type { Order, PlanAboard, PlanPlace, PlansAboard, SeaRoute, SeaRouteAnswer, System } from "../api/types.gen";
import { type ControlState, legTo, type Part } from "../state/control";
import { placesOfRoute, remarks, routeText } from "../state/searoute";
import type { Guard } from "../state/teleop";
import { make, setAttribute, setText } from "../ui/dom";
import { bearing, utc } from "../ui/format";
import { createConfirm } from "./confirm";
import { createCommandList } from "./history";
import { createLeaseView } from "./lease";
import { createOrders, Unanswered, windowKey } from "./orders";
import { createTeleop } from "./teleop";
import { isStraight, planOf, routeTo, sail } from "./wayto";

export interface ControlPanel {
  /** `guard`: what the vessel's grounding supervisor says. */
  update(state: ControlState, system: System | undefined, nowUs: number, guard?: Guard): void;
  /** Whether this window has control, so that a plan may be started. */
  holds(): boolean;
  /** Asks whether a plan that is aboard shall be started; with control only. */
  start(plan: PlanAboard): void;
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
}

export function createControl(root: HTMLElement, { address, me, may, steers, attention, name, pick, mark, drawRoute }: ControlNeeds): ControlPanel {
  const key = windowKey();
  const orders = createOrders(address, key);
  const trouble = make("p", { class: "note bad", role: "alert", hidden: "" });
  const failed = (text: string): void => {
    setText(trouble, text);
    setAttribute(trouble, "hidden", text ? null : "");
  };
  const heard = make("p", { class: "heard", role: "status" });
  const [leaseBox, planBox, goBox, helmBox, pastBox] = [make("section", { "aria-label": "Who has control" }), make("section", { "aria-label": "Plans aboard" }), make("section", { "aria-label": "Go somewhere" }), make("section", { "aria-label": "Steer by hand" }), make("section", {})];
  const confirmBox = make("div");
  const box = make("div", { class: "control" }, leaseBox, trouble, confirmBox, heard, planBox, goBox, ...(may && steers ? [helmBox] : []), pastBox);
  root.append(box);
  const confirm = createConfirm(confirmBox);
  const leaseView = createLeaseView(leaseBox, me, key, may, orders, confirm, failed);
  const past = createCommandList(pastBox, heard);
  let system: System | undefined;
  let part: Part = "free";
  /** The last command after which the list of plans was looked at. */
  let seen = 0;

  const said = (error: unknown): string => (error instanceof Unanswered ? error.message : reason(error));
  const give = async (order: Order): Promise<void> => {
    failed("");
    try {
      await orders.give(order);
    } catch (error) {
      failed(said(error));
    }
  };
  const leg = (to: readonly [number, number] | null | undefined): string => {
    if (!to) return "First leg: the plan names no place.";
    if (!system?.fix) return "First leg: not known, for nobody knows where the vessel is.";
    if (system.liveness !== "live") return `First leg: not known, the vessel's last position is old (${utc(system.fix.time_us, false)}).`;
    const { distance_m, bearing_rad } = legTo(system.fix, to);
    return `First leg: ${bearing(bearing_rad)}, ${Math.round(distance_m)} m.`;
  };

  // Plans aboard.
  const rows = make("tbody");
  const table = make("table", {}, make("thead", {}, make("tr", {}, ...["Plan", "Digest", "Changed", ""].map((text) => make("th", { scope: "col" }, text)))), rows);
  const none = make("p", { class: "empty" });
  const refresh = make("button", { type: "button" }, "Ask which plans are aboard");
  const stop = make("button", { type: "button" }, "Stop plan");
  planBox.append(make("h3", {}, "Plans aboard"), none, table, make("div", { class: "row" }, ...(may ? [refresh, stop] : [])));
  const start = async (plan: PlanAboard): Promise<void> => {
    failed("");
    setText(heard, `Asking ${name()} for the plan ${plan.plan_id} …`);
    try {
      const given = (await orders.ask({ kind: "plan.get", plan_id: plan.plan_id })).plan;
      setText(heard, "");
      const lines = [`Vessel: ${name()}`, `Plan: ${plan.plan_id}, ${given?.maneuvers ?? "?"} maneuvers`, `Digest: ${given?.md5 ?? plan.md5}`, leg(given?.first_deg), "The current plan or order will be cancelled."];
      confirm.ask(`Start ${plan.plan_id} on ${name()}?`, lines, `Start ${plan.plan_id}`, () => void give({ kind: "plan.start", plan_id: plan.plan_id }));
    } catch (error) {
      setText(heard, "");
      failed(`${plan.plan_id}: ${said(error)}`);
    }
  };
  const show = ({ time_us, plans }: PlansAboard): void => {
    setText(none, time_us === null ? "Not known yet which plans are aboard." : plans.length ? `As the vessel said ${utc(time_us)}.` : "No plan is stored aboard. Upload one first.");
    setAttribute(table, "hidden", plans.length ? null : "");
    rows.replaceChildren(
      ...plans.map((plan) => {
        const go = make("button", { type: "button", "aria-label": `Start ${plan.plan_id} …` }, "Start …");
        go.addEventListener("click", () => void start(plan));
        const changed = plan.changed_us === null ? "" : `${utc(plan.changed_us)} ${plan.changed_by}`;
        return make("tr", {}, make("th", { scope: "row" }, plan.plan_id), make("td", { class: "num", title: plan.md5 }, plan.md5.slice(0, 8)), make("td", {}, changed), make("td", {}, ...(may ? [go] : [])));
      }),
    );
    enable();
  };
  const look = async (): Promise<void> => {
    try {
      show(await getJson<PlansAboard>(`/api/v1/vessels/${address}/plans`));
    } catch (error) {
      failed(reason(error));
    }
  };
  refresh.addEventListener("click", () => {
    failed("");
    orders.ask({ kind: "plan.list" }).then(look, (error: unknown) => failed(`Plans aboard: ${said(error)}`));
  });
  stop.addEventListener("click", () => void give({ kind: "plan.stop" }));

  // Going somewhere.
  const number = (label: string, value: string, step: string): [HTMLLabelElement, HTMLInputElement] => {
    const input = make("input", { type: "number", step, value, required: "" });
    return [make("label", {}, `${label} `, input), input];
  };
  const [latBox, lat] = number("Latitude, °", "", "any");
  const [lonBox, lon] = number("Longitude, °", "", "any");
  const [speedBox, speed] = number("Speed, m/s", "1.0", "0.1");
  const onMap = make("button", { type: "button", "aria-pressed": "false" }, "Choose on the map");
  const go = make("button", { type: "submit" }, "Go there …");
  const form = make("form", {}, make("div", { class: "row" }, latBox, lonBox, speedBox), make("div", { class: "row" }, onMap, go));
  const choosing = (on: boolean): void => {
    setAttribute(onMap, "aria-pressed", String(on));
    pick(on ? ([latDeg, lonDeg]) => {
      [lat.value, lon.value] = [latDeg.toFixed(6), lonDeg.toFixed(6)];
      choosing(false);
      mark([latDeg, lonDeg]);
      go.focus();
    } : null);
  };
  onMap.addEventListener("click", () => choosing(onMap.getAttribute("aria-pressed") !== "true"));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const place = [lat.valueAsNumber, lon.valueAsNumber] as const;
    const mps = speed.valueAsNumber;
    mark(place);
    void toPlace(place, mps);
  });
  /** Straight where that is safe or nobody knows; else by the route that the chart has, which is shown first. */
  const toPlace = async (place: readonly [number, number], mps: number): Promise<void> => {
    failed("");
    const answer = await findWay(place, mps);
    const route = answer?.route;
    if (route && !isStraight(route)) return confirmRoute(route, place, mps);
    const closed = answer?.refusal ? [`By the chart there is no safe way: ${answer.refusal.text}`] : [];
    const lines = [`Vessel: ${name()}`, `To ${place[0].toFixed(6)}°, ${place[1].toFixed(6)}° at ${mps.toFixed(1)} m/s, straight, and stay there`, leg(place), ...closed, "The current plan or order will be cancelled. Where a sea chart is loaded, a way over danger is refused; look out yourself."];
    confirm.ask(`Send ${name()} there?`, lines, "Go", () => {
      mark(null);
      void give({ kind: "goto", lat_deg: place[0], lon_deg: place[1], speed_mps: mps });
    });
  };
  const findWay = async (place: readonly [number, number], mps: number): Promise<SeaRouteAnswer | undefined> => {
    if (!system?.fix || system.liveness !== "live") return undefined;
    setText(heard, "Looking for the way on the chart …");
    try {
      return await routeTo(address, system.fix, place, mps);
    } catch {
      // Without it the guard judges the straight way, as ever.
      return undefined;
    } finally {
      setText(heard, "");
    }
  };
  const confirmRoute = (found: SeaRoute, place: readonly [number, number], mps: number): void => {
    drawRoute?.(placesOfRoute(found));
    const plan = planOf(found, address, mps, `To ${place[0].toFixed(4)} ${place[1].toFixed(4)} ${new Date().toISOString().slice(11, 19)}`);
    const lines = [`Vessel: ${name()}`, `The straight way is closed by the chart. By a route of ${found.legs.length} legs: ${routeText(found)}`, ...remarks({ route: found, refusal: null }), "It goes aboard as a plan, is started, and the vessel stays at its end. The current plan or order will be cancelled; look out yourself."];
    confirm.ask(`Send ${name()} there by this route?`, lines, "Go by this route", () => {
      mark(null);
      sail(plan, address, key, orders, (text) => setText(heard, text)).catch((error: unknown) => {
        setText(heard, "");
        failed(said(error));
      });
    }, () => drawRoute?.(null));
  };
  if (may) goBox.append(make("h3", {}, "Go to a point"), form);

  const helm = may && steers ? createTeleop(helmBox, { address, key, orders, confirm, name, attention: () => attention?.() }) : undefined;

  const enable = (): void => {
    const here = part === "here";
    for (const one of [stop, onMap, go, ...rows.querySelectorAll("button")]) {
      one.disabled = !here;
      one.title = here ? "" : "Take control first.";
    }
  };
  void look();

  return {
    holds: () => part === "here",
    start(plan) {
      if (part === "here") void start(plan);
    },
    update(state, now, nowUs, guard) {
      system = now;
      const before = part;
      part = leaseView.update(state, nowUs);
      if (part !== before) {
        if (part !== "here") confirm.close();
        enable();
      }
      helm?.update(part === "here", guard);
      const known = state.commands;
      past.update(known);
      const stored = known.find((one) => one.over && /^plan\.(upload|delete|list)$/.test(one.order));
      if (stored && stored.id !== seen) {
        seen = stored.id;
        void look();
      }
    },
  };
}
