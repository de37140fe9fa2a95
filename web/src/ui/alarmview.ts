// What the alarm bar and the list under it are made of, and how alarms are drawn into them.

import type { Alarm, AlarmNote } from "../api/types.gen";
import { counts, PRIORITIES, type Priority, SHAPES } from "../state/alarms";
import { alarmText } from "../state/alarmwords";
import { named } from "./alarmrow";
import { make, setAttribute, setText } from "./dom";
import { utc } from "./format";
import { t } from "../words/words";

/** What happened to an alarm, by the server's words. */
const HAPPENED: Readonly<Record<string, string>> = {
  raised: t("raised"),
  again: t("raised again"),
  "more urgent": t("more urgent"),
  returned: t("condition ended"),
  over: t("over"),
  "off the shelf": t("unshelved"),
  escalated: t("escalated"),
  acknowledged: t("acknowledged"),
  shelved: t("shelved"),
};

export interface AlarmView {
  readonly numbers: HTMLElement;
  readonly worst: HTMLElement;
  readonly arm: HTMLButtonElement;
  /** Read out at once, and when nothing else is. */
  readonly urgent: HTMLElement;
  readonly calm: HTMLElement;
  readonly rows: HTMLElement;
  readonly asideTitle: HTMLElement;
  readonly aside: HTMLElement;
  readonly past: HTMLElement;
  readonly pastBox: HTMLDetailsElement;
  readonly none: HTMLElement;
  readonly list: HTMLElement;
  /** Says what went wrong; empty for nothing. */
  failed(text: string): void;
}

/** Builds the bar and its list, which opens and closes, in `root`. */
export function createAlarmView(root: HTMLElement): AlarmView {
  const numbers = make("span", { class: "counts" });
  const worst = make("span", { class: "worst" });
  const open = make("button", { type: "button", class: "open", "aria-expanded": "false", "aria-controls": "alarm-list" }, numbers, worst);
  const arm = make("button", { type: "button", class: "arm" }, t("Sound off: turn on"));
  // What is urgent interrupts a screen reader, what is not waits.
  const [urgent, calm] = [make("p", { class: "hidden", "aria-live": "assertive" }), make("p", { class: "hidden", "aria-live": "polite" })];
  const trouble = make("p", { class: "note bad", role: "alert", hidden: "" });
  const rows = make("ul", { class: "alarm-rows" });
  const asideTitle = make("h3", { hidden: "" }, t("Shelved"));
  const aside = make("ul", { class: "alarm-rows" });
  const past = make("ol", { class: "alarm-past" });
  const pastBox = make("details", {}, make("summary", {}, t("Recent events")), past, make("a", { href: "/alarms" }, t("Alarm history")));
  const none = make("p", { class: "empty" }, t("No alarms."));
  const list = make("div", { id: "alarm-list", class: "alarm-list", role: "region", "aria-label": t("Alarms"), tabindex: "-1", hidden: "" }, trouble, none, rows, asideTitle, aside, pastBox);
  root.append(make("div", { class: "alarm-bar" }, open, arm), urgent, calm, list);
  opens(open, list);
  const failed = (text: string): void => {
    setText(trouble, text);
    setAttribute(trouble, "hidden", text ? null : "");
  };
  return { numbers, worst, arm, urgent, calm, rows, asideTitle, aside, past, pastBox, none, list, failed };
}

function opens(open: HTMLElement, list: HTMLElement): void {
  open.addEventListener("click", () => {
    const opened = open.getAttribute("aria-expanded") !== "true";
    setAttribute(open, "aria-expanded", String(opened));
    setAttribute(list, "hidden", opened ? null : "");
    if (opened) list.focus();
  });
  list.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || open.getAttribute("aria-expanded") !== "true") return;
    event.preventDefault();
    open.click();
    open.focus();
  });
}

/** How many there are of each priority. */
export function drawCounts(numbers: HTMLElement, all: readonly Alarm[]): void {
  const number = counts(all);
  const badges = PRIORITIES.filter((one) => number[one]).map((one: Priority) => ({ one, text: `${SHAPES[one]} ${number[one]}` }));
  const key = badges.map(({ one, text }) => one + text).join();
  if (numbers.dataset["key"] === key) return;
  numbers.dataset["key"] = key;
  numbers.replaceChildren(...badges.map(({ one, text }) => make("span", { class: "badge", "data-priority": one }, text, make("span", { class: "hidden" }, ` ${named(one)}`))));
}

/** What happened lately, as the server keeps it. */
export function drawPast(past: HTMLElement, history: readonly AlarmNote[], vesselName: (vessel: number | null) => string): void {
  past.replaceChildren(...history.map((note) => make("li", {}, make("span", { class: "num" }, utc(note.time_us)), ` ${vesselName(note.vessel)}: ${named(note.priority)} ${HAPPENED[note.what] ?? note.what}${note.by ? ` ${t("by {by}", { by: note.by })}` : ""}: ${alarmText(note)}`)));
  if (!history.length) past.append(make("li", {}, t("Nothing since the server started.")));
}

export interface AlarmRows {
  /** Takes away the rows of alarms that are not among `ids`. */
  keep(ids: ReadonlySet<number>): void;
  /** Shows `all` in `place`, in this order. */
  fill(place: HTMLElement, all: readonly Alarm[]): void;
}

/** The rows of alarms, made by `row` when an alarm changed; `list` takes the focus that a replaced row had. */
export function createRows(list: HTMLElement, row: (alarm: Alarm) => HTMLElement): AlarmRows {
  const shown = new Map<number, { readonly root: HTMLElement; readonly drawn: string }>();
  const replace = (before: HTMLElement, after: HTMLElement): void => {
    if (!before.parentElement) return;
    // Who was at this alarm stays at it, though not at another button under the same finger.
    const focused = before.contains(document.activeElement);
    before.replaceWith(after);
    if (focused) list.focus();
  };
  return {
    keep(ids) {
      for (const [id, one] of shown) {
        if (ids.has(id)) continue;
        one.root.remove();
        shown.delete(id);
      }
    },
    fill(place, all) {
      all.forEach((alarm, index) => {
        const drawn = JSON.stringify({ ...alarm, sounded: 0 });
        let one = shown.get(alarm.id);
        if (!one || one.drawn !== drawn) {
          const fresh = { root: row(alarm), drawn };
          if (one) replace(one.root, fresh.root);
          shown.set(alarm.id, fresh);
          one = fresh;
        }
        if (place.children[index] !== one.root) place.insertBefore(one.root, place.children[index] ?? null);
      });
    },
  };
}
