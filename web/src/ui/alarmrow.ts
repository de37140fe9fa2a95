// One alarm in the list under the alarm bar: what is wrong, what to do, and the buttons of who may act on it.

import type { Alarm } from "../api/types.gen";
import { type Priority, PRIORITY_WORDS, SHAPES, stateText, whenText } from "../state/alarms";
import { adviceOf, alarmText } from "../state/alarmwords";
import { make } from "./dom";
import { t } from "../words/words";

/** For how long an alarm is shelved, minutes. */
const SHELF_MIN = [10, 30, 60, 240, 720];

/** Asks the server for something under `/api/v1/alarms/`. */
export type Act = (path: string, body?: unknown) => Promise<void>;

/** A priority in words. */
export const named = (priority: string): string => PRIORITY_WORDS[priority as Priority] ?? priority;

/** The row of `alarm`; `may` says whether the person may act on it. */
export function alarmRow(alarm: Alarm, may: boolean, act: Act): HTMLElement {
  const title = `${alarm.vessel_name ?? t("Server")}: ${alarmText(alarm)}`;
  const head = make("p", { class: "title" }, make("span", { class: "badge", "data-priority": alarm.priority }, `${SHAPES[alarm.priority as Priority] ?? ""} ${named(alarm.priority)}`), " ", make("strong", {}, title));
  const times = alarm.count > 1 ? `, ${t("{n} times", { n: alarm.count })}` : "";
  const more = `${alarm.escalated ? `; ${t("more urgent because it was not acknowledged")}` : ""}${alarm.chatters ? `; ${t("comes and goes, so it is held")}` : ""}`;
  const where = make("p", { class: "dim" }, `${stateText(alarm)} · ${whenText(alarm)}${times}${more}`);
  const { action, consequence, cause } = adviceOf(alarm);
  const advice = make("dl", {}, make("dt", {}, t("What to do")), make("dd", {}, action), make("dt", {}, t("If ignored")), make("dd", {}, consequence), make("dt", {}, t("Why")), make("dd", {}, cause));
  return make("li", { "data-alarm": alarm.kind, "data-state": alarm.state, "data-priority": alarm.priority }, head, where, advice, buttons(alarm, title, may, act));
}

function buttons(alarm: Alarm, title: string, may: boolean, act: Act): HTMLElement {
  const row = make("div", { class: "row" });
  if (may && alarm.wants_acknowledgement) {
    const know = make("button", { type: "button", class: "main", "aria-label": t("Acknowledge: {title}", { title }) }, t("Acknowledge"));
    know.addEventListener("click", () => void act(`${alarm.id}/acknowledge`));
    row.append(know);
  }
  if (may && alarm.priority !== "emergency" && !alarm.shelved) row.append(shelf(alarm, title, act));
  row.append(make("a", { href: `/help/alarms#${alarm.kind}`, "aria-label": t("How to recover: {title}", { title }) }, t("How to recover")));
  if (alarm.vessel !== null) row.append(make("a", { href: `/vessels/${alarm.vessel}`, "aria-label": t("Open the vessel {name}", { name: alarm.vessel_name ?? "" }) }, t("Open the vessel")));
  return row;
}

function shelf(alarm: Alarm, title: string, act: Act): HTMLElement {
  const minutes = make("select", { "aria-label": t("For how long: {title}", { title }) }, ...SHELF_MIN.map((one) => make("option", { value: String(one) }, one < 60 ? `${one} min` : `${one / 60} h`)));
  const why = make("input", { type: "text", maxlength: "300", required: "", "aria-label": t("Why: {title}", { title }), placeholder: t("why") });
  const form = make("form", { class: "row" }, minutes, why, make("button", { type: "submit" }, t("Shelve")));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    void act(`${alarm.id}/shelve`, { minutes: Number(minutes.value), reason: why.value.trim() });
  });
  return make("details", { class: "shelf" }, make("summary", {}, t("Shelve …")), form);
}
