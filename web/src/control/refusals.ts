// Where an order was refused: marked on the map, and listed under what was said, each line a way there. The refusal itself
// has the legs and their spots, whether the server refused or the vessel.

import { Refusal } from "../api/http";
import type { Command, GuardReason } from "../api/types.gen";
import type { RefusedOnMap } from "../map/danger";
import { legsOfGoto, spotsOf } from "../state/refusal";
import { make } from "../ui/dom";
import { t } from "../words/words";

/** Spots that are listed and marked. */
const LISTED = 20;
/** Orders that are waited for; older ones are no news. */
const WATCHED = 20;

export class Refusals {
  readonly root = make("div", { class: "note bad guard", role: "group", "aria-label": t("Where it was refused"), hidden: "" });
  /** Orders given from here, until it is known what became of them. */
  private readonly watched = new Set<number>();

  constructor(private readonly map: RefusedOnMap | undefined) {}

  /** The vessel may refuse this yet. */
  watch({ id }: Command): void {
    this.watched.add(id);
    const [oldest] = this.watched;
    if (this.watched.size > WATCHED && oldest !== undefined) this.watched.delete(oldest);
  }

  /** What became of what is watched. */
  update(commands: readonly Command[]): void {
    for (const { id, over, order, steps } of commands) {
      if (!over || !this.watched.delete(id)) continue;
      const last = steps.at(-1);
      if (last?.stage === "refused") this.draw(last.leg ? [last.leg] : [], order);
    }
  }

  /** An order of this kind was refused. */
  tell(error: unknown, order: string): void {
    this.draw((error instanceof Refusal && error.why.guard?.reasons) || [], order);
  }

  clear(): void {
    this.draw([], "");
  }

  private draw(legs: readonly GuardReason[], order: string): void {
    const spots = spotsOf((order === "goto" ? legsOfGoto(legs) : legs).slice(0, LISTED));
    this.root.hidden = !spots.length || !this.map;
    this.map?.show(spots);
    const rows = spots.map((spot) => {
      const button = make("button", { type: "button", class: "spot", title: t("Show it on the map") }, spot.text);
      button.addEventListener("click", () => this.map?.go(spot));
      return make("li", {}, button);
    });
    const away = make("button", { type: "button" }, t("Remove the marks"));
    away.addEventListener("click", () => this.clear());
    this.root.replaceChildren(make("strong", {}, t("Where it was refused")), make("ul", {}, ...rows), away);
  }
}
