// Follow and course up: the map goes and turns with the vessel that is chosen, until somebody leads it elsewhere.

import type OlMap from "ol/Map";
import { fromLonLat } from "ol/proj";
import type { Fix } from "../api/types.gen";
import { setAttribute } from "../ui/dom";
import { t } from "../words/words";
import type { MapTools } from "./tools";

export interface Follow {
  /** The place of the vessel is drawn; undefined while there is none. */
  update(fix: Pick<Fix, "lat_deg" | "lon_deg" | "course_rad" | "heading_rad"> | undefined): void;
  /** Somebody wants north up: the map no longer turns with the vessel. */
  northUp(): void;
}

export function createFollow(map: OlMap, tools: MapTools): Follow {
  const view = map.getView();
  const follow = tools.button("follow", t("Follow"), t("The map stays on the vessel until it is dragged"));
  const course = tools.button("course", t("Course up"), t("The map turns with the vessel's course; without one, with its heading"));
  let [follows, turns] = [false, false];
  let fix: Parameters<Follow["update"]>[0];
  /** While the map is turned from here; any other turn is somebody's own. */
  let turning = false;
  const turn = (rotation_rad: number): void => {
    turning = true;
    view.setRotation(rotation_rad);
    turning = false;
  };
  const apply = (): void => {
    if (!fix) return;
    if (follows) view.setCenter(fromLonLat([fix.lon_deg, fix.lat_deg]));
    const up = fix.course_rad ?? fix.heading_rad;
    if (turns && up !== null) turn(-up);
  };
  const set = (nextFollows: boolean, nextTurns: boolean): void => {
    [follows, turns] = [nextFollows, nextTurns];
    setAttribute(follow, "aria-pressed", String(follows));
    setAttribute(course, "aria-pressed", String(turns));
    apply();
  };
  set(false, false);
  follow.addEventListener("click", () => set(!follows, turns));
  course.addEventListener("click", () => {
    set(follows, !turns);
    if (!turns) turn(0);
  });
  // Nothing is answered: what answers false ends the drag.
  map.on("pointerdrag", () => {
    if (follows) set(false, turns);
  });
  map.getTargetElement()?.addEventListener("keydown", (event) => {
    if (follows && event.key.startsWith("Arrow")) set(false, turns);
  });
  view.on("change:rotation", () => {
    if (turns && !turning) set(follows, false);
  });
  return {
    update(next) {
      fix = next;
      apply();
    },
    northUp() {
      set(follows, false);
      turn(0);
    },
  };
}
