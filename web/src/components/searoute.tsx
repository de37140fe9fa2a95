// The panel of a route on the sea chart: what is asked of the water, what came of it, and what to do with it.

import type { Signal } from "@preact/signals";
import type { SeaRouteAnswer } from "../api/types.gen";
import { remarks, routeText } from "../state/searoute";
import { t } from "../words/words";

export interface SeaRouteModel {
  readonly open: Signal<boolean>;
  /** How many places are chosen. */
  readonly chosen: Signal<number>;
  readonly depth: Signal<number>;
  readonly clearance: Signal<number>;
  readonly answer: Signal<SeaRouteAnswer | undefined>;
  readonly trouble: Signal<string>;
  readonly busy: Signal<boolean>;
  /** What it goes around, in words; empty for a route by itself. */
  readonly around: Signal<string>;
}

export interface SeaRouteActions {
  ask(): void;
  explain(): void;
  take(): void;
  lessVia(): void;
  swap(): void;
  close(): void;
}

export function SeaRoutePanel({ model, act }: { readonly model: SeaRouteModel; readonly act: SeaRouteActions }) {
  if (!model.open.value) return null;
  const { answer, trouble, chosen, around } = model;
  const route = answer.value?.route;
  return (
    <section class="sea-route" aria-labelledby="sea-route-title">
      <h2 id="sea-route-title">{around.value ? t("Way around: {place}", { place: around.value }) : t("Route on the chart")}</h2>
      <p class="dim">{hint(chosen.value, around.value !== "")}</p>
      <Wanted label={t("Least depth")} id="sea-route-depth" unit="m" value={model.depth} most={30} step={0.5} then={act.ask} />
      <Wanted label={t("Keep clear by")} id="sea-route-clearance" unit="m" value={model.clearance} most={300} step={1} then={act.ask} />
      <p class="num totals" role="status" data-bad={answer.value?.refusal ? "" : undefined}>{route ? routeText(route) : model.busy.value ? t("Planning …") : ""}</p>
      {answer.value && remarks(answer.value).map((text) => <p key={text} class={`note ${answer.value?.refusal ? "bad" : "warn"}`}>{text}</p>)}
      {trouble.value && <p class="note bad" role="alert">{trouble.value}</p>}
      <div class="row">
        {route && <button type="button" class="main" onClick={act.take}>{around.value ? t("Take this way") : t("Add to the plan")}</button>}
        {answer.value?.refusal?.code === "no_way" && <button type="button" disabled={model.busy.value} onClick={act.explain}>{t("Find what would work")}</button>}
        {chosen.value > 2 && <button type="button" onClick={act.lessVia}>{t("Remove the last place to pass")}</button>}
        {chosen.value > 1 && !around.value && <button type="button" onClick={act.swap}>{t("Other way round")}</button>}
        <button type="button" onClick={act.close}>{t("Close")}</button>
      </div>
    </section>
  );
}

function hint(chosen: number, around: boolean): string {
  if (around) return t("Pull the line to pass elsewhere.");
  if (chosen === 0) return t("Click on the map where the route begins.");
  if (chosen === 1) return t("Click on the map where it leads.");
  return t("Drag A, B or the line. A click moves B.");
}

function Wanted({ label, id, unit, value, most, step, then }: { readonly label: string; readonly id: string; readonly unit: string; readonly value: Signal<number>; readonly most: number; readonly step: number; readonly then: () => void }) {
  const set = (text: string): void => {
    const number = Number(text);
    if (!Number.isFinite(number) || text.trim() === "") return;
    value.value = Math.max(0, number);
    then();
  };
  return (
    <div class="field wanted">
      <label for={id}>{label} ({unit})</label>
      <input type="range" min="0" max={most} step={step} value={value.value} aria-label={`${label}, ${unit}`} onInput={(event) => set(event.currentTarget.value)} />
      <input id={id} class="num" type="number" min="0" max="20000" step={step} value={value.value} onChange={(event) => set(event.currentTarget.value)} />
    </div>
  );
}
