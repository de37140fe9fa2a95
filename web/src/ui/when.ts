// Times are typed as they stand everywhere on the pages, ISO 8601 in UTC, whatever the browser's own fields would make of its
// locale; a button opens the browser's calendar.

import { icon } from "./icons";
import { make } from "./dom";
import { t } from "../words/words";

/** What a field shows while it is empty. */
export const LIKE = { day: "2026-06-01", time: "2026-06-01 12:00:00" } as const;
export type When = keyof typeof LIKE;

/** Adds the calendar to a field of times; the field tells of what is chosen as of what is typed. */
export function withCalendar(field: HTMLInputElement, kind: When): void {
  const picker = make("input", { type: kind === "day" ? "date" : "datetime-local", step: "1", class: "hidden", tabindex: "-1", "aria-hidden": "true" });
  const name = field.labels?.[0]?.textContent?.trim();
  const open = make("button", { type: "button", class: "calendar", "aria-label": name ? t("Choose in a calendar: {field}", { field: name }) : t("Choose in a calendar"), title: t("Choose in a calendar") });
  open.append(icon("calendar"));
  open.addEventListener("click", () => {
    picker.value = field.value.trim().replace(" ", "T").replace(/(\.\d+)?Z?$/i, "");
    // Where nothing is chosen a browser begins at its local time. A day chosen as it stands would give no event.
    if (!picker.value && kind === "time") picker.value = new Date().toISOString().slice(0, 19);
    try {
      picker.showPicker();
    } catch {
      // This browser has none to open from a button: what is typed counts.
      field.focus();
    }
  });
  picker.addEventListener("input", () => {
    field.value = picker.value.replace("T", " ");
    for (const name of ["input", "change"]) field.dispatchEvent(new Event(name, { bubbles: true }));
  });
  field.after(open, picker);
}

/** The same for fields that came with the page. */
export function createCalendars(): void {
  for (const field of document.querySelectorAll<HTMLInputElement>("input[data-when]")) withCalendar(field, field.dataset["when"] === "day" ? "day" : "time");
}
