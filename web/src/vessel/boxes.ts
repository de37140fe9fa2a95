// Where things stand on a vessel's page.

import { hexAddress } from "../ui/format";
import { make } from "../ui/dom";
import { t } from "../words/words";

export type Tab = "Control" | "Plots" | "Values" | "Entities" | "Log book" | "Tags" | "Link loss" | "Parameters";

/** What is written on the tabs. */
export const TAB_WORDS: Readonly<Record<Tab, string>> = {
  Control: t("Control"),
  Plots: t("Plots"),
  Values: t("Values"),
  Entities: t("Entities"),
  "Log book": t("Log book"),
  Tags: t("Tags"),
  "Link loss": t("Link loss"),
  Parameters: t("Parameters"),
};

/** Tabs that are about a stretch of time. */
export const TIMED: readonly string[] = ["Plots", "Log book", "Tags"];

export interface Boxes {
  readonly title: HTMLElement;
  /** Who has control. */
  readonly who: HTMLElement;
  readonly head: HTMLElement;
  readonly replay: HTMLElement;
  readonly tiles: HTMLElement;
  readonly map: HTMLElement;
  readonly mapFrame: HTMLElement;
  /** Where the vessel was at the time that is pointed to. */
  readonly here: HTMLElement;
  /** Which part of the tags is on the map. */
  readonly tagsCut: HTMLElement;
  readonly time: HTMLElement;
  readonly beside: HTMLElement;
  readonly side: HTMLElement;
  /** Shown where nothing is recorded. */
  readonly nothing: HTMLElement;
  readonly panels: Readonly<Record<Tab, HTMLElement>>;
  /** Orders, and what stands in their place while the past is looked at. */
  readonly control: HTMLElement;
  readonly fromPast: HTMLElement;
  readonly loss: HTMLElement;
}

export function createBoxes(root: HTMLElement, address: number, given: string | null): Boxes {
  const title = root.querySelector<HTMLElement>("h1") ?? make("h1", {}, given ?? hexAddress(address));
  const who = make("p", { class: "in-control", role: "status" });
  const replay = make("section", { class: "replay", "aria-label": t("Present or past") });
  const head = make("div", { class: "vessel-head" }, title, who, replay);
  const tiles = make("section", { class: "instruments", "aria-label": t("Instruments") }, head);
  const map = make("div", { class: "map", tabindex: "0", role: "application", "aria-label": t("Map. Arrow keys move it, plus and minus zoom; instruments and tables tell the same.") });
  const here = make("p", { class: "here num", role: "status" });
  const tagsCut = make("p", { class: "tags-cut", role: "status" });
  const mapFrame = make("div", { class: "map-box" }, map, here, tagsCut);
  const time = make("section", { class: "timebar", "aria-label": t("Time") });
  const nothing = make("p", { class: "empty", hidden: "" }, t("Nothing is recorded of this vessel yet. Import a log of it under Admin, Import; then it can be replayed here."));
  const side = make("div", { class: "side" });
  const beside = make("section", { class: "beside", "aria-label": t("Vessels") });
  const panel = (): HTMLElement => make("div", { class: "tabpanel" });
  // In the order of their tabs.
  const panels = { Control: panel(), Plots: panel(), Values: panel(), Entities: panel(), "Log book": panel(), Tags: panel(), "Link loss": panel(), Parameters: panel() };
  // Whoever looks at the past commands nothing by accident. STOP is not in here.
  const control = make("div", { class: "control-box" });
  const fromPast = make("p", { class: "note warn", hidden: "" }, t("You look at the past: nothing is commanded from here. STOP works, and Back to live brings the commands back."));
  panels.Control.append(fromPast, control);
  const loss = make("div", { class: "linkloss" });
  panels["Link loss"].append(loss);
  root.append(tiles, mapFrame, make("div", { class: "work" }, time, nothing, side));
  return { title, who, head, replay, tiles, map, mapFrame, here, tagsCut, time, beside, side, nothing, panels, control, fromPast, loss };
}
