// Where detections were, in squares that the server counted, and the area that is drawn on the chart.

import { toLonLat } from "ol/proj";
import type { Signal } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import type { DetectionsSummary, PlanPlace } from "../api/types.gen";
import { createMap } from "../map/map";
import { pictureOf } from "../map/picture";
import { createSeaRoute } from "../map/searoute";
import { createSquares, SQUARES_LAYER } from "../map/squares";
import { cornersOfText, squareNumbers, textOfCorners } from "../state/explore";
import { csv, save } from "../ui/csv";
import { position } from "../ui/format";
import { t } from "../words/words";
import { saveCanvas, SVG } from "./plotfile";

/** Corners of an area at most, as the server has it. */
const MOST = 100;

interface Needs {
  readonly found: DetectionsSummary | undefined;
  readonly area: Signal<string>;
  /** Called when an area is drawn to its end, or gone. */
  done(): void;
  readonly drawing: Signal<boolean>;
}

interface Made {
  show(found: DetectionsSummary | undefined): void;
  draw(corners: readonly PlanPlace[]): void;
  picture(): Promise<HTMLCanvasElement>;
  /** The same with the dots as a drawing. */
  drawing(): Promise<string>;
  dispose(): void;
}

export function ExploreMap({ found, area, done, drawing }: Needs) {
  const [box, made] = [useRef<HTMLDivElement>(null), useRef<Made | undefined>(undefined)];
  const [middle, move] = useState<PlanPlace | undefined>(undefined);
  const [wrong, say] = useState("");
  const corners = cornersOfText(area.value);
  const take = (taken: Promise<void> | undefined): void => {
    say("");
    void taken?.catch(() => say(t("This browser could not draw the picture.")));
  };
  const add = (corner: PlanPlace): void => {
    const now = cornersOfText(area.value);
    if (now.length < MOST) area.value = textOfCorners([...now, corner]);
  };
  useEffect(() => {
    if (!box.current) return undefined;
    made.current = make(box.current, (corner) => {
      if (!drawing.value) return false;
      add(corner);
      return true;
    }, move);
    return () => made.current?.dispose();
  }, []);
  useEffect(() => made.current?.show(found), [found]);
  useEffect(() => made.current?.draw(corners), [area.value]);
  return (
    <section class="plot-file" aria-label={t("Where")}>
      <h2>{t("Where")}</h2>
      <div class="map-box explore-map"><div ref={box} class="map" tabIndex={0} role="application" aria-label={t("Map of detections. Arrow keys move it, plus and minus zoom; the CSV has the same.")} /></div>
      <p class="row no-print">
        {!drawing.value && <button type="button" onClick={() => { [area.value, drawing.value] = ["", true]; }}>{t("Draw an area")}</button>}
        {drawing.value && <button type="button" disabled={!middle} onClick={() => { if (middle) add(middle); }}>{t("Corner in the middle of the map")}</button>}
        {drawing.value && <button type="button" class="main" disabled={corners.length < 3} onClick={() => { drawing.value = false; done(); }}>{t("Use this area")}</button>}
        {area.value && <button type="button" onClick={() => { [area.value, drawing.value] = ["", false]; done(); }}>{t("Remove the area")}</button>}
        <button type="button" onClick={() => take(made.current?.picture().then((canvas) => saveCanvas(canvas, "detections-by-place.png")))}>PNG</button>
        <button type="button" onClick={() => take(made.current?.drawing().then((svg) => save("detections-by-place.svg", svg, SVG)))}>SVG</button>
        {found && found.squares.length > 0 && <button type="button" onClick={() => { const { head, rows } = squareNumbers(found); save("detections-by-place.csv", csv(head, rows)); }}>CSV</button>}
      </p>
      <p role="status">{drawing.value ? t("Click the corners on the map, in order: {n} so far.", { n: corners.length }) : ""}</p>
      {drawing.value && middle && <p class="dim" data-middle>{t("The middle of the map is {place}.", { place: position(middle) })}</p>}
      <p class="bad-text" role="alert">{wrong}</p>
    </section>
  );
}

function make(box: HTMLElement, clicked: (corner: PlanPlace) => boolean, moved: (middle: PlanPlace) => void): Made {
  let squares: ReturnType<typeof createSquares> | undefined;
  const map = createMap(box, { showAll: () => squares?.fit() });
  const [shown, ring] = [createSquares(map.ol), createSeaRoute(map)];
  squares = shown;
  map.clicks.claim("edit", ({ coordinate }) => clicked(placeOf(coordinate)));
  map.ol.on("moveend", () => moved(placeOf(map.ol.getView().getCenter() ?? [0, 0])));
  let fits = true;
  return {
    show(found) {
      shown.show(found?.squares ?? []);
      if (fits && found?.squares.length) {
        shown.fit();
        fits = false;
      }
    },
    draw: (corners) => ring.update([], [], { areas: [], slow: [], others: [], drawing: corners.length > 2 ? [...corners, ...corners.slice(0, 1)] : corners, gap: undefined }),
    picture: () => pictureOf(map),
    drawing: async () => shown.drawing(await pictureOf(map, SQUARES_LAYER)),
    dispose: () => { shown.dispose(); map.dispose(); },
  };
}

function placeOf(coordinate: readonly number[]): PlanPlace {
  const [lon_deg = 0, lat_deg = 0] = toLonLat([...coordinate]);
  return { lat_deg, lon_deg };
}
