// Routes on the sea chart in the plan editor: places are chosen on the map, the server answers while they are dragged, and
// what came of it becomes a path of the plan, or the way around a refused leg.

import { signal } from "@preact/signals";
import { h } from "preact";
import { getJson, postJson, reason } from "../api/http";
import type { ChartSet, GuardReason, PlanDocument, PlanPlace, SeaRoute, SeaRouteAnswer, SeaRouteCurrentGrid, SeaRouteObjective, SeaRouteProgress, SeaRouteRequest } from "../api/types.gen";
import { SeaRoutePanel, type SeaRouteModel } from "../components/searoute";
import { createMount } from "../components/mount";
import type { FleetMap } from "../map/map";
import { createSeaRoute, type SeaRouteOnMap } from "../map/searoute";
import { type Around, keptSpeedText, placesOfRoute, routesOf, speedFor, stretchAt, withRoute, withWayAround } from "../state/searoute";
import { isTime, pickedUs } from "../state/takeout";
import { newKey } from "../state/window";
import { type Area, crosses, hasRoom, keepAreas, keepSlow, keptAreas, keptSlow, limitWrong, type SlowArea, zonesOf } from "../state/avoided";
import { same } from "../state/plan";
import { t } from "../words/words";
import type { PlanEditing } from "./editing";

/** The server gives a long route up after 90 s. */
const PATIENCE_MS = 100_000;
/** What takes longer than this is a long route, whose water is searched for the first time. */
const LONG_MS = 3_000;
/** How often the page asks how far a long route has come. */
const PROGRESS_MS = 1_000;
/** A file of currents comes by a slow link. */
const FILE_PATIENCE_MS = 120_000;
/** Larger files are not taken by the server, bytes. */
const MOST_BYTES = 8 * 2 ** 20;
/** Of an area with a speed limit that was just drawn, m/s. */
const LIMIT_MPS = 1;
const MOST_PLACES = 50;
/** Other routes to choose from. */
const ALTERNATIVES = 2;

export interface SeaRouteNeeds {
  readonly map: FleetMap;
  readonly root: HTMLElement;
  readonly editing: PlanEditing;
  /** Under which name areas to avoid are kept in this browser. */
  readonly plan: string;
  /** The middle of the map. */
  centre(): PlanPlace;
  /** Where the plan's vessel is, if that is known. */
  vessel(): PlanPlace | undefined;
  /** It was opened or closed. */
  changed(): void;
}

export class SeaRouteTool {
  private chosen: PlanPlace[] = [];
  private around: Around | undefined;
  private readonly onMap: SeaRouteOnMap;
  private readonly model: SeaRouteModel = { open: signal(false), chosen: signal(0), depth: signal(5), clearance: signal(15), objective: signal("shortest"), deeper: signal(0), off: signal(0), traffic: signal(true), set: signal(0), drift: signal(0), grid: signal(undefined), gridName: signal(""), gridWrong: signal(""), gridBusy: signal(false), depart: signal(""), answer: signal(undefined), way: signal(0), trouble: signal(""), busy: signal(false), long: signal(false), progress: signal(undefined), avoid: signal([]), slow: signal([]), limitWrong: signal(undefined), drawing: signal(undefined), around: signal("") };
  /** A place is under the hand. */
  private dragging = false;
  /** One question is on its way; the newest one that came meanwhile is asked after it. */
  private asking = false;
  private again = false;
  /** Counts what was changed: an answer to what was asked before is not shown. */
  private version = 0;
  /** Ends the question that is on its way. */
  private leaving = new AbortController();
  /** Ends the reading of a file of currents. */
  private reading = new AbortController();
  /** The departure of the last valid text, µs since 1970; null for now. */
  private departUs: number | null = null;

  constructor(private readonly needs: SeaRouteNeeds) {
    this.onMap = createSeaRoute(needs.map, {
      moved: (index, place, done) => this.move(index, place, done),
      pulled: (leg, place) => this.pull(leg, place),
    });
    const act = {
      ask: () => this.anew(),
      aim: (objective: SeaRouteObjective) => {
        this.model.objective.value = objective;
        this.anew();
      },
      traffic: (minded: boolean) => {
        this.model.traffic.value = minded;
        this.anew();
      },
      currents: (file: File | undefined) => void this.currents(file),
      depart: (text: string) => {
        this.model.depart.value = text;
        if (text !== "" && !isTime(text)) return;
        this.departUs = text === "" ? null : pickedUs(text);
        this.anew();
      },
      explain: () => void this.explain(),
      stop: () => this.stop(),
      take: () => this.take(),
      keptSpeed: (route: SeaRoute) => this.keptSpeed(route),
      choose: (way: number) => this.choose(way),
      moreVia: () => this.via(this.needs.centre()),
      lessVia: (index: number) => this.place(this.chosen.filter((_, at) => at !== index)),
      draw: () => this.sketch([]),
      corner: () => this.corner(this.needs.centre()),
      lessCorner: () => this.sketch(this.model.drawing.value?.slice(0, -1)),
      drawn: () => this.drawn((corners) => this.areas([...this.model.avoid.value, corners])),
      slowed: () => this.drawn((corners) => this.slowAreas([...this.model.slow.value, { corners, most_mps: LIMIT_MPS }])),
      limit: (index: number, text: string) => this.limit(index, text),
      lessSlow: (index: number) => this.slowAreas(this.model.slow.value.filter((_, at) => at !== index)),
      leave: () => this.sketch(undefined),
      lessArea: (index: number) => this.areas(this.model.avoid.value.filter((_, at) => at !== index)),
      use: ({ depth_m, clearance_m }: { depth_m?: number | null; clearance_m?: number | null }) => {
        this.model.depth.value = depth_m ?? this.model.depth.value;
        this.model.clearance.value = clearance_m ?? this.model.clearance.value;
        this.anew();
      },
      swap: () => this.place([...this.chosen].reverse()),
      close: () => this.close(),
    };
    this.model.avoid.value = keptAreas(localStorage, needs.plan);
    this.model.slow.value = keptSlow(localStorage, needs.plan);
    createMount(needs.root)(h(SeaRoutePanel, { model: this.model, act }));
  }

  get open(): boolean {
    return this.model.open.value;
  }

  /** Limits of the chart in force are where one begins. */
  limits(chart: ChartSet): void {
    this.model.depth.value = chart.autonomous_m;
  }

  /** Opens it, from the end of the plan or from where its vessel is; or closes it. */
  toggle(): void {
    if (this.open) return this.close();
    const { editing } = this.needs;
    const last = editing.plan.maneuvers.at(-1)?.task;
    const end = last?.kind === "follow_path" ? last.points.at(-1) : last?.at;
    const begin = end ?? this.needs.vessel();
    this.begin(begin ? [begin] : [], undefined, "");
  }

  /** Looks for a way around a refused leg. */
  goAround({ maneuver, part, number, from, to }: GuardReason): void {
    if (from && to) this.begin([from, to], { maneuver, part, number }, maneuver);
  }

  /** A click on the map beside everything; whether it was meant for the route. */
  takes(place: PlanPlace): boolean {
    if (!this.open) return false;
    if (this.model.drawing.value) {
      this.corner(place);
      return true;
    }
    if (this.around) return false;
    this.place(this.chosen.length < 2 ? [...this.chosen, place] : [...this.chosen.slice(0, -1), place]);
    return true;
  }

  close(): void {
    this.version++;
    this.leaving.abort();
    this.reading.abort();
    [this.model.gridWrong.value, this.model.gridBusy.value] = ["", false];
    this.model.open.value = false;
    [this.chosen, this.around] = [[], undefined];
    [this.model.answer.value, this.model.drawing.value] = [undefined, undefined];
    this.onMap.clear();
    this.needs.changed();
  }

  private begin(chosen: PlanPlace[], around: Around | undefined, words: string): void {
    this.around = around;
    this.model.around.value = words;
    this.model.open.value = true;
    this.place(chosen);
    this.needs.changed();
    this.needs.root.scrollIntoView({ block: "nearest" });
  }

  private place(chosen: PlanPlace[]): void {
    this.chosen = chosen;
    this.model.chosen.value = chosen.length;
    this.model.answer.value = undefined;
    this.draw();
    this.anew();
  }

  private move(index: number, place: PlanPlace, done: boolean): void {
    this.dragging = !done;
    // The ends of a leg that is sailed around belong to the plan.
    const end = index === 0 || index === this.chosen.length - 1;
    if (this.around && end) return;
    this.chosen = this.chosen.map((one, at) => (at === index ? place : one));
    this.draw();
    if (done) this.anew();
    else void this.ask();
  }

  private pull(leg: number, place: PlanPlace): number {
    const route = this.chosenRoute();
    const stretch = route ? stretchAt(this.chosen, placesOfRoute(route), leg) : 0;
    if (this.chosen.length >= MOST_PLACES) return stretch;
    this.chosen = [...this.chosen.slice(0, stretch + 1), place, ...this.chosen.slice(stretch + 1)];
    this.model.chosen.value = this.chosen.length;
    return stretch + 1;
  }

  /** A place to pass, the last before the goal. */
  private via(place: PlanPlace): void {
    if (this.chosen.length < 2 || this.chosen.length >= MOST_PLACES) return;
    this.place([...this.chosen.slice(0, -1), place, ...this.chosen.slice(-1)]);
  }

  private sketch(corners: Area | undefined): void {
    this.model.drawing.value = corners;
    this.draw();
  }

  private corner(place: PlanPlace): void {
    const corners = this.model.drawing.value;
    if (corners && hasRoom(this.allAreas(), corners)) this.sketch([...corners, place]);
  }

  private allAreas(): Area[] {
    return [...this.model.avoid.value, ...this.model.slow.value.map(({ corners }) => corners)];
  }

  /** Gives the area that was drawn, unless its sides cross. */
  private drawn(take: (corners: Area) => void): void {
    const { drawing } = this.model;
    if (!drawing.value || drawing.value.length < 3) return;
    if (crosses(drawing.value)) {
      this.model.trouble.value = t("Two sides of the area cross: remove corners and draw it without.");
      return;
    }
    const corners = drawing.value;
    this.model.trouble.value = "";
    drawing.value = undefined;
    take(corners);
  }

  private areas(areas: readonly Area[]): void {
    this.model.avoid.value = areas;
    keepAreas(localStorage, this.needs.plan, areas);
    this.otherAreas();
  }

  private slowAreas(areas: readonly SlowArea[]): void {
    this.model.slow.value = areas;
    this.model.limitWrong.value = undefined;
    keepSlow(localStorage, this.needs.plan, areas);
    this.otherAreas();
  }

  private otherAreas(): void {
    this.model.answer.value = undefined;
    this.draw();
    this.anew();
  }

  private limit(index: number, text: string): void {
    const wrong = limitWrong(text);
    if (wrong) this.model.limitWrong.value = { at: index, text: wrong };
    else this.slowAreas(this.model.slow.value.map((area, at) => (at === index ? { ...area, most_mps: Number(text) } : area)));
  }

  /** Has the server read a file of currents; what is wrong with it is said at its field. */
  private async currents(file: File | undefined): Promise<void> {
    const { grid, gridName, gridWrong, gridBusy } = this.model;
    this.reading.abort();
    const reading = (this.reading = new AbortController());
    gridWrong.value = "";
    if (!file) {
      [grid.value, gridName.value, gridBusy.value] = [undefined, "", false];
      return this.anew();
    }
    if (file.size > MOST_BYTES) {
      gridWrong.value = t("The file is larger than {most} MB: take out what is not needed.", { most: MOST_BYTES / 2 ** 20 });
      return;
    }
    gridBusy.value = true;
    try {
      const read = await postJson<SeaRouteCurrentGrid>("/api/v1/chart/currents", FILE_PATIENCE_MS, file, reading.signal);
      if (reading.signal.aborted) return;
      [grid.value, gridName.value] = [read, file.name];
      this.anew();
    } catch (error) {
      if (!reading.signal.aborted) gridWrong.value = reason(error);
    } finally {
      if (!reading.signal.aborted) gridBusy.value = false;
    }
  }

  private question(explain: boolean): SeaRouteRequest {
    const { editing } = this.needs;
    const { set, drift } = this.model;
    const grid = this.model.grid.value;
    return {
      points: this.chosen.map(({ lat_deg, lon_deg }) => [lat_deg, lon_deg]),
      vessel: editing.plan.vessel,
      least_depth_m: this.model.depth.value,
      clearance_m: this.model.clearance.value,
      turn_radius_m: null,
      stray_m: null,
      objective: this.model.objective.value,
      prefer_depth_m: this.model.deeper.value > this.model.depth.value ? this.model.deeper.value : null,
      prefer_off_m: this.model.off.value > this.model.clearance.value ? this.model.off.value : null,
      prefer_factor: null,
      traffic_factor: this.model.traffic.value ? null : 1,
      speed_mps: editing.speed.unit === "mps" ? editing.speed.value : null,
      zones: zonesOf(this.model.avoid.value, this.model.slow.value),
      current: !grid && drift.value > 0 ? { set_deg: set.value, drift_mps: drift.value } : null,
      current_grid: grid ?? null,
      depart_us: grid ? this.departUs : null,
      // Under the hand the one route is asked for, as often as can be; with places to pass a person has chosen already.
      alternatives: this.dragging || this.chosen.length > 2 ? 0 : ALTERNATIVES,
      explain,
      progress: null,
    };
  }

  /** Leaves the question that is on its way: the server stops planning. */
  private stop(): void {
    this.version++;
    this.again = false;
    this.leaving.abort();
  }

  /** Asks what was never asked: an answer that is still on its way is of something else. */
  private anew(): void {
    this.version++;
    this.leaving.abort();
    void this.ask();
  }

  private async ask(): Promise<void> {
    if (this.asking) {
      this.again = true;
      return;
    }
    if (!this.open || this.chosen.length < 2) return;
    this.asking = true;
    await this.send(false);
    this.asking = false;
    if (!this.again) return;
    this.again = false;
    void this.ask();
  }

  private async explain(): Promise<void> {
    await this.send(true);
  }

  private async send(explain: boolean): Promise<void> {
    const { model, version } = this;
    const leaving = (this.leaving = new AbortController());
    const following = new AbortController();
    const name = newKey();
    const long = setTimeout(() => {
      model.long.value = true;
      void this.follow(name, following.signal);
    }, LONG_MS);
    const question = this.question(explain);
    // While a place is dragged the answer to where it was just now is shown; what would do is looked for once.
    const isOfNow = (): boolean => this.open && version === this.version && (!explain || same(question, this.question(true)));
    model.busy.value = true;
    try {
      const answer = await postJson<SeaRouteAnswer>("/api/v1/chart/route", PATIENCE_MS, { ...question, progress: name }, leaving.signal);
      if (isOfNow()) [model.way.value, model.answer.value, model.trouble.value] = [0, answer, ""];
    } catch (error) {
      if (isOfNow()) [model.answer.value, model.trouble.value] = [undefined, reason(error)];
    }
    clearTimeout(long);
    following.abort();
    [model.busy.value, model.long.value, model.progress.value] = [false, false, undefined];
    this.draw();
  }

  /** Shows how far a question has come, until it is answered. */
  private async follow(name: string, signal: AbortSignal): Promise<void> {
    while (!signal.aborted) {
      try {
        const progress = await getJson<SeaRouteProgress>(`/api/v1/chart/route/${name}`, signal);
        if (!signal.aborted) this.model.progress.value = progress;
      } catch {
        // It was answered meanwhile, or its own request says that the server is not reached.
      }
      await new Promise((resolve) => setTimeout(resolve, PROGRESS_MS));
    }
  }

  private draw(): void {
    const { answer, avoid, drawing, slow, way } = this.model;
    const route = this.chosenRoute();
    const others = routesOf(answer.value).map((other, index) => ({ number: index + 1, places: placesOfRoute(other) }));
    const gap = answer.value?.refusal?.passable?.gap_at;
    this.onMap.update(this.chosen, route ? placesOfRoute(route) : [], {
      areas: avoid.value,
      slow: slow.value.map(({ corners, most_mps }) => ({ corners, label: `${most_mps} m/s` })),
      drawing: drawing.value,
      others: others.filter((_, index) => index !== way.value),
      gap: gap ? { lat_deg: gap[0], lon_deg: gap[1] } : undefined,
    });
  }

  private chosenRoute(): SeaRoute | undefined {
    return routesOf(this.model.answer.value)[this.model.way.value];
  }

  private choose(way: number): void {
    this.model.way.value = way;
    this.draw();
  }

  /** What the panel says of the speed that the plan will have. */
  private keptSpeed(route: SeaRoute): string {
    const { editing } = this.needs;
    const around = this.around;
    const step = around && editing.plan.maneuvers.find(({ id }) => id === around.maneuver);
    return keptSpeedText(route, step?.speed ?? speedFor(route, editing.speed));
  }

  private take(): void {
    const route = this.chosenRoute();
    if (!route) return;
    const { editing } = this.needs;
    const next: PlanDocument = this.around ? withWayAround(editing.plan, route, this.around) : withRoute(editing.plan, route, speedFor(route, editing.speed), editing.selected?.step);
    this.close();
    editing.change(next);
  }
}
