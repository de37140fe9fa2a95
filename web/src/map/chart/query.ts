// What is charted at a place, in a panel over the map.

import type { ChartNear, ChartObject } from "../../api/types.gen";
import { make } from "../../ui/dom";
import { position } from "../../ui/format";
import { count, t } from "../../words/words";
import { depthWords, zoneText } from "./api";

export interface QueryPanel {
  readonly root: HTMLElement;
  /** `focus` takes the keyboard there, for who came by keyboard. */
  show(lat_deg: number, lon_deg: number, near: ChartNear, focus: boolean): void;
  fail(text: string): void;
  close(): void;
}

/** `closed` is called when somebody closes it. */
export function createQuery(closed: () => void): QueryPanel {
  const title = make("h2", { tabindex: "-1" }, t("What is here"));
  const shut = make("button", { type: "button", "aria-label": t("Close what is here") }, "✕");
  const body = make("div", { class: "chart-query-body", tabindex: "0", role: "region", "aria-label": t("Charted here") });
  const root = make("section", { class: "chart-query", "aria-label": t("What is here"), hidden: "" }, make("header", {}, title, shut), body);
  const close = (): void => {
    if (root.hidden) return;
    root.hidden = true;
    closed();
  };
  shut.addEventListener("click", close);
  root.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    event.stopPropagation();
    close();
  });
  return {
    root,
    show(lat_deg, lon_deg, near, focus) {
      const { depth } = near;
      const facts: [string, string][] = [[t("Place"), position({ lat_deg, lon_deg })]];
      if (depth.margin_m !== null) facts.push([t("Margin"), t("{margin} m against the safety depth", { margin: depth.margin_m.toFixed(1).replace("-", "−") })]);
      facts.push([t("For vessels"), depth.autonomous ? t("may go by themselves") : depth.navigable ? t("only under an operator's hand") : t("closed")]);
      if (depth.words) facts.push([t("Decided by"), `${depth.words}${depth.class ? ` (${depth.class})` : ""}${depth.name ? ` “${depth.name}”` : ""}`]);
      if (depth.cell) facts.push([t("Chart"), source(depth.cell, depth.edition ?? "?", depth.update ?? "?", depth.scale ?? 0)]);
      if (depth.kind !== "no-data") facts.push([t("Quality"), t("zone of confidence {zone}", { zone: zoneText(depth.zone) })]);
      const objects = near.objects.map(object);
      body.replaceChildren(
        make("p", { class: "chart-query-depth num" }, depthWords(depth)),
        list(facts),
        ...(objects.length ? [make("h3", {}, t("Objects: {n}", { n: objects.length })), ...objects] : []),
      );
      body.scrollTop = 0;
      root.hidden = false;
      if (focus) title.focus();
    },
    fail(text) {
      body.replaceChildren(make("p", { class: "note warn" }, text));
      root.hidden = false;
    },
    close,
  };
}

function object(one: ChartObject): HTMLElement {
  const name = `${one.words}${one.name ? ` “${one.name}”` : ""}`;
  const away = one.distance_m >= 0.5 ? t("{distance} m away", { distance: one.distance_m.toFixed(0) }) : t("here");
  const facts: [string, string][] = [];
  if (one.depth_m !== null) facts.push([t("Depth"), `${one.depth_m.toFixed(1).replace("-", "−")} m`]);
  facts.push(...one.attributes.map((each): [string, string] => [`${each.words} (${each.name})`, each.text]), [t("Chart"), source(one.cell, one.edition, one.update, one.scale)]);
  return make("details", {}, make("summary", {}, make("strong", {}, name), " ", make("span", { class: "dim" }, `${one.class} · ${away}`)), list(facts));
}

function list(facts: readonly (readonly [string, string])[]): HTMLElement {
  return make("dl", {}, ...facts.flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)]));
}

function source(cell: string, edition: string, update: string, scale: number): string {
  return `${t("{cell} edition {edition} update {update}", { cell, edition, update })}${scale ? `, 1 : ${count(scale)}` : ""}`;
}
