// Sending a vessel to a place: typed or chosen on the map, straight where that is safe or nobody knows, else by the route
// that the chart has; in two steps either way.

import type { PlanPlace, SeaRoute, SeaRouteAnswer } from "../api/types.gen";
import { placesOfRoute, remarks, routeText } from "../state/searoute";
import { readAngle, toShown, toWire } from "../state/units";
import { make, setAttribute } from "../ui/dom";
import { position } from "../ui/format";
import { t } from "../words/words";
import type { Giving } from "./giving";
import { isStraight, planOf, routeTo, sail } from "./wayto";

type Place = readonly [number, number];

export interface GoThereNeeds {
  /** The next click on the map gives a place, degrees; null ends the wait. */
  pick(told: ((place: Place) => void) | null): void;
  /** Marks a place on the map; null for none. */
  mark(place: Place | null): void;
  /** Shows a route on the map while it is to be confirmed; null for none. */
  drawRoute?(places: readonly PlanPlace[] | null): void;
}

export class GoThere {
  readonly root = make("section", { "aria-label": t("Go somewhere") });
  private readonly lat = angle();
  private readonly lon = angle();
  private readonly speed = make("input", { type: "number", step: "any", min: "0.1", value: "2", required: "" });
  private readonly onMap = make("button", { type: "button", "aria-pressed": "false" }, t("Choose on the map"));
  private readonly go = make("button", { type: "submit" }, t("Go there …"));
  private readonly form = make(
    "form",
    {},
    make("div", { class: "row" }, labelled(t("Latitude, °"), this.lat), labelled(t("Longitude, °"), this.lon), labelled(t("Speed, kn"), this.speed)),
    make("div", { class: "row" }, this.onMap, this.go),
  );

  constructor(private readonly giving: Giving, private readonly needs: GoThereNeeds) {
    this.root.append(make("h3", {}, t("Go to a point")), this.form);
    this.onMap.addEventListener("click", () => this.choose(this.onMap.getAttribute("aria-pressed") !== "true"));
    for (const one of [this.lat, this.lon]) one.addEventListener("input", () => one.setCustomValidity(""));
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      const place = this.placeTyped();
      if (!place) return;
      needs.mark(place);
      void this.toPlace(place, toWire(this.speed.valueAsNumber, "m/s"));
    });
  }

  /** Whether this window has control. */
  enable(here: boolean): void {
    for (const one of [this.onMap, this.go]) {
      one.disabled = !here;
      one.title = here ? "" : t("Take control first.");
    }
  }

  private choose(on: boolean): void {
    setAttribute(this.onMap, "aria-pressed", String(on));
    const take = ([latDeg, lonDeg]: Place): void => {
      [this.lat.value, this.lon.value] = [latDeg.toFixed(6), lonDeg.toFixed(6)];
      this.choose(false);
      this.needs.mark([latDeg, lonDeg]);
      this.go.focus();
    };
    this.needs.pick(on ? take : null);
  }

  /** The place that is typed; what is wrong with it is said at its field. */
  private placeTyped(): Place | undefined {
    const [latDeg, lonDeg] = [readAngle(this.lat.value, "lat"), readAngle(this.lon.value, "lon")];
    this.lat.setCustomValidity(latDeg === undefined ? t("like {example}", { example: t("63.44 or 63° 26.4′ N") }) : "");
    this.lon.setCustomValidity(lonDeg === undefined ? t("like {example}", { example: t("10.4 or 10° 24′ E") }) : "");
    return this.form.reportValidity() && latDeg !== undefined && lonDeg !== undefined ? [latDeg, lonDeg] : undefined;
  }

  private async toPlace(place: Place, mps: number): Promise<void> {
    const { giving } = this;
    giving.fail("");
    const answer = await this.findWay(place, mps);
    const route = answer?.route;
    if (route && !isStraight(route)) return this.confirmRoute(route, place, mps);
    const name = giving.name();
    const closed = answer?.refusal ? [t("By the chart there is no safe way: {text}", { text: answer.refusal.text })] : [];
    const lines = [t("Vessel: {name}", { name }), t("To {place} at {speed}, straight, and stay there", { place: position({ lat_deg: place[0], lon_deg: place[1] }), speed: `${toShown(mps, "m/s")} kn` }), giving.leg(place), ...closed, t("The current plan or order will be cancelled. Where a sea chart is loaded, a way over danger is refused; look out yourself.")];
    giving.confirm.ask(t("Send {name} there?", { name }), lines, t("Go"), () => {
      this.needs.mark(null);
      void giving.give({ kind: "goto", lat_deg: place[0], lon_deg: place[1], speed_mps: mps });
    });
  }

  private async findWay(place: Place, mps: number): Promise<SeaRouteAnswer | undefined> {
    const { giving } = this;
    if (!giving.system?.fix || giving.system.liveness !== "live") return undefined;
    giving.say(t("Looking for the way on the chart …"));
    try {
      return await routeTo(giving.address, giving.system.fix, place, mps);
    } catch {
      // Without it the guard judges the straight way, as ever.
      return undefined;
    } finally {
      giving.say("");
    }
  }

  private confirmRoute(found: SeaRoute, place: Place, mps: number): void {
    const { giving, needs } = this;
    const name = giving.name();
    needs.drawRoute?.(placesOfRoute(found));
    const plan = planOf(found, giving.address, mps, `To ${place[0].toFixed(4)} ${place[1].toFixed(4)} ${new Date().toISOString().slice(11, 19)}`);
    const lines = [t("Vessel: {name}", { name }), t("The straight way is closed by the chart. By a route of {n} legs: {route}", { n: found.legs.length, route: routeText(found) }), ...remarks({ route: found, refusal: null }), t("It goes aboard as a plan, is started, and the vessel stays at its end. The current plan or order will be cancelled; look out yourself.")];
    giving.confirm.ask(t("Send {name} there by this route?", { name }), lines, t("Go by this route"), () => {
      needs.mark(null);
      sail(plan, giving.address, giving.key, giving.orders, (text) => giving.say(text)).catch((error: unknown) => {
        giving.say("");
        giving.refused(error, "plan.start");
      });
    }, () => needs.drawRoute?.(null));
  }
}

/** A field for an angle as positions are shown, or in degrees. */
function angle(): HTMLInputElement {
  return make("input", { type: "text", required: "", autocomplete: "off", spellcheck: "false" });
}

function labelled(label: string, input: HTMLInputElement): HTMLElement {
  return make("label", {}, `${label} `, input);
}
