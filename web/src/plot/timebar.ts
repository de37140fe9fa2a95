// The stretch of time that map, plots and tables share: presets, moving, zooming, typing.

import { make, setAttribute, setText } from "../ui/dom";
import { utc } from "../ui/format";
import { t } from "../words/words";
import { ends, isLive, type Range } from "./model";

const MINUTE_US = 60_000_000;
const PRESETS: readonly (readonly [string, number])[] = [
  ["5 min", 5 * MINUTE_US],
  ["15 min", 15 * MINUTE_US],
  ["1 h", 60 * MINUTE_US],
  ["6 h", 360 * MINUTE_US],
  ["24 h", 1_440 * MINUTE_US],
  ["7 d", 10_080 * MINUTE_US],
];

export interface TimeBarHandlers {
  choose(range: Range): void;
  pan(part: number): void;
  scale(factor: number): void;
  /** All that was recorded. */
  all(): void;
}

export interface TimeBar {
  update(range: Range, nowUs: number): void;
}

/** Shows the time in `root`. */
export function createTimeBar(root: HTMLElement, handlers: TimeBarHandlers): TimeBar {
  const preset = make("select", { "aria-label": t("Stretch of time") });
  preset.append(make("option", { value: "" }, t("chosen time")));
  for (const [name, span] of PRESETS) preset.append(make("option", { value: String(span) }, t("last {span}", { span: name })));
  preset.append(make("option", { value: "all" }, t("all recorded")));
  preset.addEventListener("change", () => {
    if (preset.value === "all") handlers.all();
    else if (preset.value) handlers.choose({ spanUs: Number(preset.value) });
  });
  const button = (text: string, label: string, act: () => void): HTMLButtonElement => {
    const made = make("button", { type: "button", "aria-label": label, title: label }, text);
    made.addEventListener("click", act);
    return made;
  };
  const [from, to] = [make("input", { class: "time", "aria-label": t("From, UTC"), autocomplete: "off" }), make("input", { class: "time", "aria-label": t("To, UTC"), autocomplete: "off" })];
  const problem = make("span", { class: "bad-text", role: "alert" });
  const form = make("form", { class: "row times" }, from, make("span", {}, t("to")), to, make("button", {}, t("Show")), problem);
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const [start, end] = [read(from.value), read(to.value)];
    const right = start !== undefined && end !== undefined && start < end;
    setText(problem, right ? "" : t("Give two times as 2026-06-01 12:00:00, the first before the second."));
    if (right) handlers.choose({ fromUs: start, toUs: end });
  });
  const live = make("span", { class: "tag" });
  root.append(
    preset,
    make("span", { class: "buttons" }, button("◀", t("Earlier"), () => handlers.pan(-0.5)), button("▶", t("Later"), () => handlers.pan(0.5)), button("+", t("Zoom in"), () => handlers.scale(0.5)), button("−", t("Zoom out"), () => handlers.scale(2))),
    form,
    live,
  );
  return {
    update(range, nowUs) {
      const { fromUs, toUs } = ends(range, nowUs);
      const editing = form.contains(document.activeElement);
      if (!editing) {
        from.value = utc(fromUs).slice(0, 19);
        to.value = utc(toUs).slice(0, 19);
        setText(problem, "");
      }
      const known = isLive(range) ? PRESETS.find(([, span]) => span === range.spanUs) : undefined;
      if (document.activeElement !== preset) preset.value = known ? String(known[1]) : "";
      setText(live, isLive(range) ? t("follows the present") : t("stands still"));
      setAttribute(root, "data-live", isLive(range) ? "" : null);
    },
  };
}

/** A time as people write it, UTC. */
function read(text: string): number | undefined {
  const told = /^\s*(\d{4}-\d{2}-\d{2})[ T](\d{2}:\d{2}(?::\d{2}(?:\.\d+)?)?)Z?\s*$/.exec(text);
  const ms = told ? Date.parse(`${told[1]}T${told[2]}Z`) : NaN;
  return Number.isFinite(ms) ? ms * 1_000 : undefined;
}
