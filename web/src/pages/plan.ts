// The editor of one plan: map, maneuvers, what they take, and how it is kept. What is edited stands in `plan/editing`; here
// the parts are put together and drawn.

import { h } from "preact";
import { getJson, postJson, reason } from "../api/http";
import type { LiveFrame, PlanCheck, PlanDocument, StoredPlan, System } from "../api/types.gen";
import { DrawBar } from "../components/drawbar";
import { createMount } from "../components/mount";
import { PlanBar } from "../components/planbar";
import { createRefused } from "../map/danger";
import { createMap, type FleetMap } from "../map/map";
import { createAboard } from "../plan/aboard";
import { createCanvas, type PlanCanvas } from "../plan/canvas";
import { PlanEditing } from "../plan/editing";
import { createHeadForm } from "../plan/headform";
import { createJudge, type Judge } from "../plan/judge";
import { createKeeper, forget, type Keeper, type Keeping, type Left, leftovers } from "../plan/keeper";
import { keepingText, offerConflict, offerLeft } from "../plan/offers";
import { createProfile } from "../plan/profile";
import { SeaRouteTool } from "../plan/searoute";
import { SpeedView } from "../plan/speeds";
import { createSteps } from "../plan/steps";
import { createToolBar, mapKeys, pageKeys } from "../plan/toolbar";
import { createVerdict } from "../plan/verdict";
import { asSeen, EMPTY, type FleetState, serverNowUs } from "../state/fleet";
import { tame } from "../state/foreign";
import { same, vertices, withName, withSpeed, withTask } from "../state/plan";
import { type Judgement, type LeastDepth, type Spot, verdictOf } from "../state/planverdict";
import { type Chrome, createChrome } from "../ui/chrome";
import { make, setText } from "../ui/dom";
import { hexAddress, utc } from "../ui/format";
import { t } from "../words/words";

const PATIENCE_MS = 10_000;
/** Vessels are redrawn at least so often, for they grow old, ms. */
const VESSELS_MS = 500;
/** The depth beside the plan is looked at this far, m. */
const BESIDE_M = 5;
/** Of one text in the bar. */
const MOST_LETTERS = 300;
const MINUTES_KEY = "lutra.minutes";

type Names = Readonly<Record<string, string>>;

export function startPlan(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["vessels"] ?? "{}") as Names;
  const path = `/api/v1/plans/${Number(root.dataset["id"])}`;
  void getJson<StoredPlan>(path).then(
    (stored) => void new PlanPage(root, stored, path, names),
    (error: unknown) => {
      createChrome({ messages: ["VehicleState"], events: false, every_ms: 500 }, {});
      root.append(make("p", { class: "note bad", role: "alert" }, reason(error), " ", make("a", { href: "/plans" }, t("All plans"))));
    },
  );
}

/** Where things stand on the page. */
function boxesOf(root: HTMLElement, writable: boolean) {
  const map = make("div", { class: "map", tabindex: "0", role: "application", "aria-label": t("Map of the plan. Arrow keys move the chosen place by a metre, with Shift by ten, and with Ctrl its whole maneuver; without one they move the map. D copies the maneuver, R reverses its way, Shift and R the whole plan. Delete takes the place away, Escape lets go. The list of maneuvers does the same.") });
  const tools = make("div", { class: "tools", role: "toolbar", "aria-label": t("Tools") });
  const drawing = make("div", { class: "drawing", role: "group", "aria-label": t("The area that you draw"), hidden: "" });
  const head = make("section", { class: "plan-head", "aria-label": t("Plan") });
  const status = make("p", { class: "keeping", role: "status" });
  const offers = make("div", { class: "offers" });
  const route = make("div");
  const totals = make("p", { class: "totals num", role: "status", "aria-label": t("What the plan takes") });
  const troubles = make("div", { class: "troubles", role: "status" });
  const depths = make("section", { class: "plan-profile plot", "aria-labelledby": "profile-title", hidden: "" });
  const list = make("section", { class: "plan-list", "aria-label": t("List of maneuvers") });
  const form = make("section", { class: "plan-form", "aria-labelledby": "step-title", hidden: "" });
  const ship = make("section", { class: "plan-aboard", "aria-labelledby": "aboard-title" });
  const side = make("div", { class: "plan-side" }, route, head, offers, status, totals, troubles, list, form, depths, ...(writable ? [ship] : []));
  const bar = make("section", { class: "plan-bar", "aria-label": t("Plan, verdict, and what to do with it") });
  // What gets the focus is scrolled to beside it.
  new ResizeObserver(() => document.documentElement.style.setProperty("--plan-bar-height", `${Math.ceil(bar.getBoundingClientRect().height)}px`)).observe(bar);
  root.append(bar, make("div", { class: "plan-body" }, make("div", { class: "plan-main" }, tools, drawing, make("div", { class: "map-box" }, map)), side));
  return { bar, drawing, map, tools, head, status, offers, route, totals, troubles, depths, list, form, ship, side };
}

class PlanPage {
  private readonly boxes;
  private readonly editing: PlanEditing;
  private readonly map: FleetMap;
  private readonly canvas: PlanCanvas;
  private readonly route: SeaRouteTool;
  private readonly judge: Judge;
  private readonly steps;
  private readonly toolBar;
  private readonly headForm;
  private readonly keeper: Keeper | undefined;
  private readonly aboard;
  private readonly chrome: Chrome;
  private readonly drawn: ReturnType<typeof createMount>;
  private readonly drawnArea: ReturnType<typeof createMount>;
  private judgement: Judgement = { kind: "asked" };
  private least: LeastDepth | undefined;
  /** The plan as it was saved last, and under which revision. */
  private saved: StoredPlan | undefined;
  private minutes = localStorage.getItem(MINUTES_KEY) === "yes";
  private readonly speeds = new SpeedView(() => this.draw());
  private fleet: FleetState = EMPTY;
  private linked = true;
  /** All parts are made. */
  private ready = false;
  private systems: readonly System[] = [];
  /** The map goes to the vessels at first; a plan that has places counts for more. */
  private fits: boolean;

  constructor(root: HTMLElement, private readonly first: StoredPlan, private readonly path: string, private readonly names: Names) {
    const writable = root.dataset["operator"] !== undefined;
    this.boxes = boxesOf(root, writable);
    this.drawn = createMount(this.boxes.bar);
    this.drawnArea = createMount(this.boxes.drawing);
    this.saved = first.draft ? undefined : first;
    this.fits = vertices(first.plan).length > 0;
    this.editing = this.makeEditing(writable);
    this.map = createMap(this.boxes.map, { showAll: () => this.canvas.fit() });
    this.canvas = this.makeCanvas();
    this.route = this.makeRoute();
    this.judge = this.makeJudge();
    this.steps = this.makeSteps();
    this.toolBar = createToolBar(this.boxes.tools, this.editing, {
      added: (kind) => {
        this.editing.addStep(kind, this.canvas.centre());
        this.steps.focus();
      },
      draws: () => this.boxes.map.focus(),
      route: this.route,
    });
    this.headForm = this.makeHeadForm();
    this.aboard = writable ? this.makeAboard(root.dataset["me"] ?? "") : undefined;
    pageKeys(this.editing, () => void this.save());
    mapKeys(this.boxes.map, this.editing, this.canvas);
    this.chrome = createChrome({ messages: ["VehicleState", "EstimatedState", "GpsFix", "Announce"], events: false, every_ms: 500 }, {
      frame: (fleet, frame) => this.frame(fleet, frame),
      lost: () => {
        this.linked = false;
        this.drawVessels();
      },
    });
    window.setInterval(() => this.chrome.draw("vessels", () => this.drawVessels()), VESSELS_MS);
    this.keeper = writable ? createKeeper(first, (now) => this.keeping(now)) : undefined;
    this.begin();
  }

  private begin(): void {
    const { first } = this;
    this.ready = true;
    const [left] = this.editing.writable ? leftovers(first.id) : [];
    if (left && !same(left.plan, first.plan)) this.offer(left);
    else if (left) forget(left);
    const by = { author: first.author, time: utc(first.updated_us), revision: first.revision };
    setText(this.boxes.status, first.draft ? t("Draft by {author}, {time}, revision {revision}", by) : t("Saved by {author}, {time}, revision {revision}", by));
    this.boxes.status.dataset["state"] = first.draft ? "kept" : "saved";
    this.judge.show(first.check);
    this.draw();
    this.canvas.fit();
  }

  // Made once.

  private makeEditing(writable: boolean): PlanEditing {
    return new PlanEditing(this.first.plan, writable, {
      changed: (plan) => {
        this.keeper?.changed(plan);
        this.judge.ask();
      },
      draw: () => this.draw(),
      centre: () => this.canvas.centre(),
      reveal: (place) => this.canvas.reveal(place),
    });
  }

  private makeCanvas(): PlanCanvas {
    const { editing } = this;
    return createCanvas(this.map, {
      draws: () => editing.tool !== undefined || this.route.open,
      sketches: () => editing.sketching !== undefined,
      stretches: () => editing.sketching === "rows_rectangle",
      stretched: (from, to, done) => editing.stretch(from, to, done),
      dropped: () => {
        editing.sketch.clear();
        this.drawArea();
      },
      led: (place) => {
        editing.sketch.lead(editing.sketch.corners.length ? place : undefined);
        this.drawArea();
      },
      closed: () => void editing.finish(),
      clicked: (place) => {
        if (!this.route.takes(place)) editing.clicked(place);
      },
      select: (vertex) => editing.select(vertex),
      between: (after, place) => editing.between(after, place),
      moved: (vertex, place, done) => {
        this.dragged(editing.drag(vertex, place, done));
      },
      pulled: (grip, from, to, done) => this.dragged(editing.pull(grip, from, to, done)),
      grips: editing.writable,
    });
  }

  private makeRoute(): SeaRouteTool {
    const { map, editing } = this;
    const route = new SeaRouteTool({
      map,
      root: this.boxes.route,
      editing,
      plan: this.path,
      centre: () => this.canvas.centre(),
      vessel: () => this.systems.find(({ address }) => address === editing.plan.vessel)?.fix ?? undefined,
      changed: () => {
        if (route.open) editing.letGo();
        this.toolBar.update();
      },
    });
    map.chart.onChart((chart) => route.limits(chart));
    return route;
  }

  /** Draws what is dragged while it is. */
  private dragged(plan: PlanDocument | undefined): void {
    if (!plan) return;
    this.canvas.update(plan, this.editing.selected, this.judge.legs());
    this.judge.ask();
  }

  private makeJudge(): Judge {
    const { map, boxes, editing } = this;
    const profile = createProfile(boxes.depths, BESIDE_M, (place) => map.overlays.cursor(place), (least) => {
      this.least = least;
      this.drawBar();
    });
    map.onRepaint(() => profile.repaint());
    const judge = createJudge({
      totals: boxes.totals,
      troubles: boxes.troubles,
      verdict: createVerdict(map),
      profile,
      plan: () => editing.shown,
      told: (now) => {
        this.judgement = now;
        this.drawBar();
      },
      judged: (check: PlanCheck) => {
        this.steps.check(check);
        this.canvas.update(editing.shown, editing.selected, check.maneuvers);
        this.keepFocusInSight();
      },
      go: (place) => {
        this.canvas.reveal(place);
        map.overlays.cursor(place);
      },
      around: editing.writable ? (reason) => this.route.goAround(reason) : undefined,
    }, this.first.check);
    let judgedWith: string | null | undefined;
    map.chart.onChart((chart) => {
      profile.limits(chart.set === null ? undefined : chart);
      // What was judged without a chart, or with another one, is judged again.
      if (judgedWith !== undefined && judgedWith !== chart.set) judge.ask();
      judgedWith = chart.set;
    });
    return judge;
  }

  private makeSteps() {
    const { editing, boxes } = this;
    const change = (next: PlanDocument): void => editing.change(next);
    const steps = createSteps(boxes.list, boxes.form, this.speeds, {
      select: (vertex) => editing.select(vertex),
      name: (step, id) => change(withName(editing.plan, step, id)),
      speed: (step, speed) => change(withSpeed(editing.plan, speed, step)),
      place: (vertex, place) => editing.move(vertex, place),
      values: (step, values) => change(withTask(editing.plan, step, values)),
      order: (step, by) => editing.order(step, by),
      remove(vertex, whole) {
        editing.remove(vertex, whole);
        if (whole) steps.focus();
      },
      insert: (after) => editing.insert(after),
      insertPoint: (after) => editing.insertPoint(after),
      duplicate: (step) => {
        if (editing.duplicate(step, this.canvas.apart())) steps.focus();
      },
      back: (step) => void editing.back(step),
      allBack: () => void editing.allBack(),
      onMap: () => boxes.map.focus(),
    });
    return steps;
  }

  private makeHeadForm() {
    return createHeadForm(this.boxes.head, {
      editing: this.editing,
      names: this.names,
      path: this.path,
      speeds: this.speeds,
      minutes: () => this.minutes,
      setMinutes: (whether) => {
        this.minutes = whether;
        localStorage.setItem(MINUTES_KEY, whether ? "yes" : "no");
        this.draw();
      },
    });
  }

  private makeAboard(me: string) {
    const { map, editing } = this;
    return createAboard(this.boxes.ship, {
      me,
      names: this.names,
      path: this.path,
      saved: () => {
        const { saved } = this;
        const digest = saved?.check.digest;
        return saved && digest && same(saved.plan, editing.plan) ? { name: saved.plan.name, revision: saved.revision, digest, plan: saved.plan } : undefined;
      },
      refusedOnMap: createRefused(map),
      pick: (told) => map.overlays.pick(told),
      mark: (place) => map.overlays.cursor(place ? { lat_deg: place[0], lon_deg: place[1] } : null),
      told: () => this.drawBar(),
    });
  }

  // How it is kept.

  private async save(): Promise<void> {
    const { editing, boxes } = this;
    let problems: PlanCheck["problems"] = [];
    try {
      // What was judged last may be older than what is drawn.
      problems = (await postJson<PlanCheck>("/api/v1/plans/check", PATIENCE_MS, editing.plan)).problems;
    } catch {
      // Saving tells by itself why the server does not answer.
    }
    if (!problems.length) return this.keeper?.save(editing.plan);
    await this.keeper?.keepDraft();
    // Why it could not be kept is said already.
    if (this.keeper && !this.keeper.done) return;
    setText(boxes.status, t("Not saved: the plan has problems. It is kept as a draft."));
    boxes.status.dataset["state"] = "failed";
  }

  private keeping(now: Keeping): void {
    if ("stored" in now) this.saved = now.stored.draft ? undefined : now.stored;
    this.boxes.status.dataset["state"] = now.state;
    setText(this.boxes.status, keepingText(now));
    if (now.state === "conflict") this.conflict(now.newer);
    this.keepFocusInSight();
  }

  private conflict(newer: StoredPlan): void {
    const { editing, keeper, boxes } = this;
    offerConflict(boxes.offers, newer, {
      async apart() {
        try {
          const made = await postJson<StoredPlan>("/api/v1/plans", PATIENCE_MS, editing.plan);
          keeper?.rebase(newer);
          location.assign(`/plans/${made.id}`);
        } catch (error) {
          setText(boxes.status, t("Not kept: {reason} Yours is still in this browser.", { reason: reason(error) }));
        }
        // The question stands until the other page is there, or for another try.
        return false;
      },
      theirs: () => {
        keeper?.rebase(newer);
        editing.replace(newer.plan);
        this.judge.show(newer.check);
        this.draw();
        this.keeping({ state: newer.draft ? "kept" : "saved", stored: newer });
      },
      mine: () => {
        keeper?.rebase(newer);
        keeper?.changed(editing.plan);
      },
    });
  }

  private offer(left: Left): void {
    offerLeft(this.boxes.offers, left, this.first.revision, () => {
      forget(left);
      this.editing.selected = undefined;
      this.editing.change(left.plan);
      this.canvas.fit();
    }, () => forget(left));
  }

  // What comes, and drawing.

  private frame(fleet: FleetState, frame: LiveFrame): void {
    [this.fleet, this.linked] = [fleet, true];
    this.systems = [...fleet.systems.values()].map((system) => ({ ...system, name: this.names[String(system.address)] ?? system.name }));
    this.drawVessels();
    this.aboard?.frame(frame, this.systems, serverNowUs(fleet, performance.now()));
    if (!this.fits || !this.systems.some((system) => system.fix)) return;
    this.fits = false;
    this.canvas.fit();
  }

  /** What is said above a field that is being typed in pushes it down: it stays where it is seen. */
  private keepFocusInSight(): void {
    const { activeElement } = document;
    if (activeElement && this.boxes.side.contains(activeElement)) activeElement.scrollIntoView({ block: "nearest" });
  }

  private drawVessels(): void {
    const nowUs = serverNowUs(this.fleet, performance.now());
    this.map.update(this.systems.map((system) => asSeen(system, this.fleet.values.get(system.address), nowUs, this.linked)), undefined, nowUs);
  }

  private draw(): void {
    const { editing, boxes } = this;
    // One thing at a time takes the clicks.
    if (editing.tool !== undefined && this.route.open) this.route.close();
    this.canvas.update(editing.shown, editing.selected, this.judge.legs());
    this.steps.update(editing.shown, editing.selected, this.minutes);
    if (!editing.writable) for (const one of boxes.side.querySelectorAll<HTMLInputElement>(".plan-form input, .plan-form select, .plan-form .row button, .order-buttons button")) one.disabled = true;
    this.headForm.update();
    this.toolBar.update();
    boxes.map.dataset["tool"] = editing.tool ?? "";
    this.drawArea();
    this.aboard?.prefer(editing.plan.vessel);
    this.drawBar();
  }

  /** The area that is being drawn, on the map and in its bar. */
  private drawArea(): void {
    const { editing, boxes, canvas } = this;
    const { sketch, sketching } = editing;
    const view = sketching && sketch.view(sketching);
    canvas.sketch(view);
    boxes.drawing.hidden = !view;
    if (!view) return this.drawnArea(null);
    const set = (change: () => void): void => {
      change();
      this.drawArea();
    };
    this.drawnArea(h(DrawBar, {
      told: view.told,
      spacing_m: sketch.spacing_m,
      bearing_deg: sketch.bearing_deg,
      suits: "best",
      whole: view.whole,
      finishes: sketching === "lines_polygon",
      spacing: (metres) => set(() => (sketch.spacing_m = metres)),
      bearing: (deg) => set(() => (sketch.bearing_deg = deg)),
      finish: () => void (editing.finish() && this.steps.focus()),
      cancel: () => editing.press(undefined),
    }));
  }

  /** What stays in sight: the bar, and the STOP of the vessel that it names. */
  private drawBar(): void {
    // Parts tell while they are made.
    if (!this.ready) return;
    const { editing, aboard } = this;
    const { vessel } = editing.plan;
    const chosen = aboard?.chosen() ?? (vessel === null ? undefined : { address: vessel, name: this.names[String(vessel)] ?? hexAddress(vessel) });
    this.chrome.stop?.target(chosen);
    const now = aboard?.now();
    const acts = aboard && now ? { ...now, save: () => void this.save(), upload: () => aboard.upload(), start: () => aboard.start(), choose: () => aboard.focus() } : undefined;
    const vesselText = chosen ? t("For {name}", { name: chosen.name }) : acts ? t("Choose a vessel") : t("For any vessel");
    const judged = verdictOf(editing.shown, this.judgement, this.least);
    const verdict = { ...judged, text: tame(judged.text, MOST_LETTERS) };
    this.drawn(h(PlanBar, { name: tame(editing.plan.name, MOST_LETTERS), vessel: vesselText, aboard: now?.text ?? "", verdict, acts, said: now?.said ?? "", go: (spot) => this.go(spot) }));
  }

  private go({ vertex, place }: Spot): void {
    const { editing, canvas, map, boxes } = this;
    if (vertex) editing.select(vertex);
    if (place) canvas.reveal(place);
    map.overlays.cursor(place ?? null);
    boxes.map.scrollIntoView({ block: "nearest" });
  }
}
