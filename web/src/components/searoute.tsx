// The panel of a route on the sea chart: what is asked of the water, what came of it, and what to do with it.

import type { Signal } from "@preact/signals";
import type { PlanPlace, SeaRoute, SeaRouteAnswer, SeaRouteCurrentGrid, SeaRouteObjective, SeaRoutePassable, SeaRouteProgress } from "../api/types.gen";
import { hasRoom, type SlowArea } from "../state/avoided";
import { energyOf, progressText, remarks, routeName, routesOf, routeText, savedText } from "../state/searoute";
import { timeWrong } from "../state/takeout";
import { t } from "../words/words";
import { WhenField } from "./when";

export interface SeaRouteModel {
  readonly open: Signal<boolean>;
  /** How many places are chosen. */
  readonly chosen: Signal<number>;
  readonly depth: Signal<number>;
  readonly clearance: Signal<number>;
  /** What the route is good for. */
  readonly objective: Signal<SeaRouteObjective>;
  /** Water deeper than this is preferred, m; 0 for no preference. */
  readonly deeper: Signal<number>;
  /** Water farther than this from land and shoals is preferred, m; 0 for no preference. */
  readonly off: Signal<number>;
  /** The route keeps out of traffic lanes where the way round is not far. */
  readonly traffic: Signal<boolean>;
  /** Where the current flows to (°) and how fast (m/s); 0 for still water. */
  readonly set: Signal<number>;
  readonly drift: Signal<number>;
  /** A grid of currents, in place of a steady one, and the name of its file. */
  readonly grid: Signal<SeaRouteCurrentGrid | undefined>;
  readonly gridName: Signal<string>;
  /** What is wrong with the file that was chosen last; empty where nothing is. The other: a file is being read. */
  readonly gridWrong: Signal<string>;
  readonly gridBusy: Signal<boolean>;
  /** When the route begins, as it was typed; empty for now. */
  readonly depart: Signal<string>;
  readonly answer: Signal<SeaRouteAnswer | undefined>;
  /** Which of its routes is chosen. */
  readonly way: Signal<number>;
  readonly trouble: Signal<string>;
  readonly busy: Signal<boolean>;
  /** The answer takes longer than usual, and how far it has come as soon as the server has said so. */
  readonly long: Signal<boolean>;
  readonly progress: Signal<SeaRouteProgress | undefined>;
  /** Areas to avoid. */
  readonly avoid: Signal<readonly (readonly PlanPlace[])[]>;
  /** Areas with a speed limit, and which limit was typed wrong, if one was. */
  readonly slow: Signal<readonly SlowArea[]>;
  readonly limitWrong: Signal<{ readonly at: number; readonly text: string } | undefined>;
  /** Corners of the area that is being drawn; undefined while none is. */
  readonly drawing: Signal<readonly PlanPlace[] | undefined>;
  /** What it goes around, in words; empty for a route by itself. */
  readonly around: Signal<string>;
}

export interface SeaRouteActions {
  ask(): void;
  aim(objective: SeaRouteObjective): void;
  traffic(minded: boolean): void;
  /** Reads a grid of currents; undefined for no grid. */
  currents(file: File | undefined): void;
  depart(text: string): void;
  explain(): void;
  /** Leaves the question that is on its way. */
  stop(): void;
  take(): void;
  /** What is said of the plan's speed, where it is not the route's; else empty. */
  keptSpeed(route: SeaRoute): string;
  choose(way: number): void;
  /** A place to pass in the middle of the map, and away with one, by its number among all chosen places. */
  moreVia(): void;
  lessVia(index: number): void;
  /** Begins to draw an area; a corner in the middle of the map; the last corner away; takes it to avoid it, or with a speed limit; leaves it. */
  draw(): void;
  corner(): void;
  lessCorner(): void;
  drawn(): void;
  slowed(): void;
  leave(): void;
  lessArea(index: number): void;
  lessSlow(index: number): void;
  /** Another speed limit for an area, as it was typed, m/s. */
  limit(index: number, text: string): void;
  use(passable: Partial<Pick<SeaRoutePassable, "depth_m" | "clearance_m">>): void;
  swap(): void;
  close(): void;
}

export function SeaRoutePanel({ model, act }: { readonly model: SeaRouteModel; readonly act: SeaRouteActions }) {
  if (!model.open.value) return null;
  const { answer, trouble, chosen, around } = model;
  const routes = routesOf(answer.value);
  const route = routes[model.way.value] ?? null;
  return (
    <section class="sea-route" aria-labelledby="sea-route-title">
      <h2 id="sea-route-title">{around.value ? t("Way around: {place}", { place: around.value }) : t("Route on the chart")}</h2>
      <p class="dim">{hint(chosen.value, around.value !== "")}</p>
      <Wanted label={t("Least depth")} id="sea-route-depth" unit="m" value={model.depth} most={30} limit={20_000} step={0.5} then={act.ask} />
      <Wanted label={t("Keep clear by")} id="sea-route-clearance" unit="m" value={model.clearance} most={300} limit={500} step={1} then={act.ask} />
      <Aims model={model} act={act} />
      <Wanted label={t("Prefer deeper than (0: no preference)")} id="sea-route-deeper" unit="m" value={model.deeper} most={100} limit={12_000} step={1} then={act.ask} />
      <Wanted label={t("Prefer farther off than (0: no preference)")} id="sea-route-off" unit="m" value={model.off} most={300} limit={500} step={5} then={act.ask} />
      <label class="row"><input id="sea-route-traffic" type="checkbox" checked={model.traffic.value} onChange={(event) => act.traffic(event.currentTarget.checked)} /> {t("Keep out of traffic lanes where the way round is short")}</label>
      <Currents model={model} act={act} />
      <p class="num totals" role="status" data-bad={answer.value?.refusal ? "" : undefined}>{route ? routeText(route) : planning(model)}</p>
      {model.long.value && (
        <p class="row">
          <span class="num">{model.progress.value ? progressText(model.progress.value) : ""}</span>
          <button type="button" onClick={act.stop}>{t("Stop planning")}</button>
        </p>
      )}
      <Ways answer={answer.value} model={model} act={act} />
      {answer.value && savedText(answer.value) && <p class="note num">{savedText(answer.value)}</p>}
      {answer.value && remarks({ route, refusal: answer.value.refusal }).map((text) => <p key={text} class={`note ${answer.value?.refusal ? "bad" : "warn"}`}>{text}</p>)}
      {route && energyOf(route) && <p class="note num">{energyOf(route)}</p>}
      {route && act.keptSpeed(route) && <p class="note num">{act.keptSpeed(route)}</p>}
      {trouble.value && <p class="note bad" role="alert">{trouble.value}</p>}
      <div class="row">
        {route && <button type="button" class="main" disabled={model.busy.value} onClick={act.take}>{around.value ? t("Take this way") : t("Add to the plan")}</button>}
        {answer.value?.refusal?.code === "no_way" && <button type="button" disabled={model.busy.value} onClick={act.explain}>{t("Find what would work")}</button>}
        <Offers passable={answer.value?.refusal?.passable ?? undefined} act={act} />
        {chosen.value > 1 && !around.value && <button type="button" onClick={act.swap}>{t("Other way round")}</button>}
        <button type="button" onClick={act.close}>{t("Close")}</button>
      </div>
      <Vias chosen={chosen.value} act={act} />
      <Areas model={model} act={act} />
    </section>
  );
}

function planning({ busy, long }: SeaRouteModel): string {
  if (!busy.value) return "";
  return long.value ? t("Planning a long route: the first time can take a minute …") : t("Planning …");
}

/** Does something after which its button may be gone, and gives the focus to the first button of a group, or to the depth. */
function then(act: () => void, group: string): () => void {
  return () => {
    act();
    const find = (selector: string): HTMLElement | null => document.querySelector<HTMLElement>(selector);
    requestAnimationFrame(() => (find(`#${group} button:not(:disabled)`) ?? find("#sea-route-depth"))?.focus());
  };
}

/** What the route is to be good for. */
function Aims({ model, act }: { readonly model: SeaRouteModel; readonly act: SeaRouteActions }) {
  const aims: readonly (readonly [SeaRouteObjective, string])[] = [["shortest", t("Shortest")], ["fastest", t("Fastest")], ["least_energy", t("Least energy")]];
  return (
    <div class="field">
      <label for="sea-route-aim">{t("Best route")}</label>
      <select id="sea-route-aim" value={model.objective.value} onChange={(event) => act.aim(aims[event.currentTarget.selectedIndex]?.[0] ?? "shortest")}>
        {aims.map(([aim, name]) => <option key={aim} value={aim}>{name}</option>)}
      </select>
    </div>
  );
}

/** The current: steady, or by a file with times. */
function Currents({ model, act }: { readonly model: SeaRouteModel; readonly act: SeaRouteActions }) {
  const file = (input: HTMLInputElement): void => {
    if (input.files?.[0]) act.currents(input.files[0]);
    // The same file can be chosen again after it was mended.
    input.value = "";
  };
  if (!model.grid.value) {
    return (
      <>
        <Wanted label={t("Current (0: still water)")} id="sea-route-drift" unit="m/s" value={model.drift} most={2} limit={10} step={0.1} then={act.ask} />
        {model.drift.value > 0 && <Wanted label={t("The current flows to")} id="sea-route-set" unit="°" value={model.set} most={360} limit={360} step={5} then={act.ask} />}
        <p class="row"><label class="button">{t("Current from a file (CSV, NetCDF) …")}<input class="hidden" type="file" accept=".csv,.nc,text/csv,application/x-netcdf" aria-invalid={model.gridWrong.value !== ""} aria-describedby="sea-route-currents-wrong" onChange={(event) => file(event.currentTarget)} /></label></p>
        {model.gridBusy.value && <p class="note" role="status">{t("Reading the file …")}</p>}
        <p id="sea-route-currents-wrong" class="note bad" role="alert">{model.gridWrong.value}</p>
      </>
    );
  }
  const wrong = timeWrong(model.depart.value);
  return (
    <div class="field">
      <p class="row">{model.gridName.value} <button type="button" onClick={then(() => act.currents(undefined), "sea-route-vias")}>{t("Without this current")}</button></p>
      <label for="sea-route-depart">{t("Departure (UTC), empty for now")}</label>
      <WhenField marks={{ id: "sea-route-depart", "aria-invalid": wrong !== "", "aria-describedby": "sea-route-depart-wrong" }} value={model.depart.value} changed={act.depart} />
      <p id="sea-route-depart-wrong" class="note bad">{wrong}</p>
    </div>
  );
}

/** The route that was asked for, the shortest one, and those on the other side of islands, to choose from. */
function Ways({ answer, model: { way, objective }, act }: { readonly answer: SeaRouteAnswer | undefined; readonly model: SeaRouteModel; readonly act: SeaRouteActions }) {
  const routes: readonly SeaRoute[] = routesOf(answer);
  if (!answer || routes.length < 2) return null;
  return (
    <fieldset class="ways">
      <legend>{t("Routes to choose from")}</legend>
      {routes.map((route, index) => (
        <label key={index} class="num">
          <input type="radio" name="sea-route-way" checked={way.value === index} onChange={() => act.choose(index)} /> {routeName(route, index, answer, objective.value)}
        </label>
      ))}
    </fieldset>
  );
}

/** What would do, one press away. */
function Offers({ passable, act }: { readonly passable: SeaRoutePassable | undefined; readonly act: SeaRouteActions }) {
  if (!passable) return null;
  const { depth_m, clearance_m } = passable;
  return (
    <>
      {depth_m !== null && <button type="button" onClick={then(() => act.use({ depth_m }), "sea-route-vias")}>{t("Try a least depth of {depth} m", { depth: depth_m })}</button>}
      {clearance_m !== null && <button type="button" onClick={then(() => act.use({ clearance_m }), "sea-route-vias")}>{t("Try a clearance of {distance} m", { distance: clearance_m })}</button>}
    </>
  );
}

/** Places to pass: dragged on the map, or added and removed here. */
function Vias({ chosen, act }: { readonly chosen: number; readonly act: SeaRouteActions }) {
  if (chosen < 2) return null;
  const numbers = Array.from({ length: chosen - 2 }, (_, at) => at + 1);
  return (
    <div class="row" role="group" id="sea-route-vias" aria-label={t("Places to pass")}>
      <button type="button" onClick={act.moreVia}>{t("Pass the middle of the map")}</button>
      {numbers.map((number) => <button key={number} type="button" onClick={then(() => act.lessVia(number), "sea-route-vias")}>{t("Remove place {number}", { number })}</button>)}
    </div>
  );
}

/** Areas to avoid or with a speed limit: drawn by clicks, or by corners in the middle of the map. */
function Areas({ model, act }: { readonly model: SeaRouteModel; readonly act: SeaRouteActions }) {
  const corners = model.drawing.value;
  const all = [...model.avoid.value, ...model.slow.value.map((area) => area.corners)];
  if (corners) {
    return (
      <div class="row" role="group" id="sea-route-areas" aria-label={t("The area that you draw")}>
        <p class="note" role="status">{t("Click the corners of the area: {n} so far.", { n: corners.length })}</p>
        <button type="button" class="main" disabled={corners.length < 3} onClick={then(act.drawn, "sea-route-areas")}>{t("Avoid this area")}</button>
        <button type="button" disabled={corners.length < 3} onClick={then(act.slowed, "sea-route-areas")}>{t("Limit the speed in this area")}</button>
        <button type="button" disabled={!hasRoom(all, corners)} onClick={act.corner}>{t("Corner in the middle of the map")}</button>
        <button type="button" disabled={!corners.length} onClick={corners.length > 1 ? act.lessCorner : then(act.lessCorner, "sea-route-areas")}>{t("Remove the last corner")}</button>
        <button type="button" onClick={then(act.leave, "sea-route-areas")}>{t("Cancel")}</button>
      </div>
    );
  }
  return (
    <div class="row" role="group" id="sea-route-areas" aria-label={t("Areas for the route")}>
      <button type="button" disabled={!hasRoom(all, [])} onClick={then(act.draw, "sea-route-areas")}>{t("Draw an area")}</button>
      {model.avoid.value.map((_, at) => <button key={at} type="button" onClick={then(() => act.lessArea(at), "sea-route-areas")}>{t("Remove area {number}", { number: at + 1 })}</button>)}
      {model.slow.value.map((area, at) => <Limit key={at} area={area} at={at} model={model} act={act} />)}
    </div>
  );
}

/** The speed limit of an area. */
function Limit({ area, at, model, act }: { readonly area: SlowArea; readonly at: number; readonly model: SeaRouteModel; readonly act: SeaRouteActions }) {
  const id = `sea-route-limit-${at}`;
  const wrong = model.limitWrong.value?.at === at ? model.limitWrong.value.text : "";
  return (
    <div class="field">
      <label for={id}>{t("Speed limit of area {number} (m/s)", { number: at + 1 })}</label>
      <input id={id} class="num" type="number" min="0.05" max="20" step="any" value={area.most_mps} aria-invalid={wrong !== ""} aria-describedby={`${id}-wrong`} onChange={(event) => act.limit(at, event.currentTarget.value)} />
      <button type="button" onClick={then(() => act.lessSlow(at), "sea-route-areas")}>{t("Remove speed limit {number}", { number: at + 1 })}</button>
      <p id={`${id}-wrong`} class="note bad">{wrong}</p>
    </div>
  );
}

function hint(chosen: number, around: boolean): string {
  if (around) return t("Pull the line to pass elsewhere.");
  if (chosen === 0) return t("Click on the map where the route begins.");
  if (chosen === 1) return t("Click on the map where it leads.");
  return t("Drag A, B or the line. A click moves B.");
}

function Wanted({ label, id, unit, value, most, limit, step, then }: { readonly label: string; readonly id: string; readonly unit: string; readonly value: Signal<number>; readonly most: number; readonly limit: number; readonly step: number; readonly then: () => void }) {
  const set = (text: string): void => {
    const number = Number(text);
    if (!Number.isFinite(number) || text.trim() === "") return;
    value.value = Math.min(limit, Math.max(0, number));
    then();
  };
  return (
    <div class="field wanted">
      <label for={id}>{label} ({unit})</label>
      <input type="range" min="0" max={most} step={step} value={value.value} aria-label={`${label}, ${unit}`} onInput={(event) => set(event.currentTarget.value)} />
      <input id={id} class="num" type="number" min="0" max={limit} step={step} value={value.value} onChange={(event) => set(event.currentTarget.value)} />
    </div>
  );
}
