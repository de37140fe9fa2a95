// The tags on a vessel's map, and beside its tools the legend that shows and hides them.

import { h } from "preact";
import type { Detection } from "../api/types.gen";
import { createMount } from "../components/mount";
import { type HiddenTags, keptHiddenTags, TagLegend } from "../components/taglegend";
import type { FleetMap } from "../map/map";
import { countsOf } from "../state/tags";
import { make } from "../ui/dom";
import { tagName } from "../ui/format";
import { t } from "../words/words";

/** Whether the legend is open, for as long as this window is. */
const KEPT = "lutra.tags.open";
/** On a map that is narrower the legend, which takes 200 px of it, is folded until somebody opens it, px. */
const NARROW_PX = 800;

export class TagsOnMap {
  readonly hidden: HiddenTags = keptHiddenTags();
  private readonly panel = make("section", { class: "tag-panel", id: "tag-panel", "aria-label": t("Tag legend"), hidden: "" });
  private readonly tool: HTMLButtonElement;
  private readonly draw: ReturnType<typeof createMount>;
  private all: readonly Detection[] = [];

  /** `changed` is called when others are hidden than before. */
  constructor(private readonly map: FleetMap, changed: () => void) {
    this.tool = map.tools.button("tags", t("Tag legend"), t("Which tags are on the map"));
    this.tool.setAttribute("aria-controls", this.panel.id);
    this.tool.hidden = true;
    map.tools.panel(this.panel);
    this.draw = createMount(this.panel);
    this.open(this.wantsOpen());
    this.tool.addEventListener("click", () => {
      this.open(Boolean(this.panel.hidden));
      sessionStorage.setItem(KEPT, this.panel.hidden ? "no" : "yes");
    });
    this.panel.addEventListener("keydown", (event) => {
      if (event.key !== "Escape") return;
      this.open(false);
      this.tool.focus();
    });
    let first = true;
    this.hidden.subscribe(() => {
      if (!first) {
        this.place();
        changed();
      }
      first = false;
    });
  }

  /** All that are in hand of the time that is looked at. */
  update(all: readonly Detection[]): void {
    this.all = all;
    this.place();
    this.tool.hidden = all.length === 0;
    if (this.tool.hidden) this.panel.hidden = true;
    else this.open(this.wantsOpen());
    this.draw(h(TagLegend, { tags: countsOf(all), hidden: this.hidden }));
  }

  shows(one: Detection): boolean {
    return !this.hidden.value.has(tagName(one));
  }

  private place(): void {
    this.map.overlays.detections(this.all.filter((one) => this.shows(one)));
  }

  private wantsOpen(): boolean {
    const kept = sessionStorage.getItem(KEPT);
    return kept === null ? (this.map.ol.getTargetElement()?.clientWidth ?? 0) >= NARROW_PX : kept === "yes";
  }

  private open(whether: boolean): void {
    this.panel.hidden = !whether || this.all.length === 0;
    this.tool.setAttribute("aria-expanded", String(!this.panel.hidden));
  }
}
