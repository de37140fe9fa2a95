// What stands behind the tabs of a vessel's page, each made once.

import { h } from "preact";
import { getJson } from "../api/http";
import type { Detections, LinkStatus, LogBook, LogNotes } from "../api/types.gen";
import { LinkTable } from "../components/linktable";
import { createMount } from "../components/mount";
import { ReadinessList } from "../components/readiness";
import { createControlSoon } from "../control/soon";
import { createRefused } from "../map/danger";
import type { FleetMap } from "../map/map";
import { createSeaRoute } from "../map/searoute";
import { createParametersLater } from "../params/later";
import { createPlotsSoon } from "../plot/soon";
import type { PlotHandlers } from "../plot/plots";
import type { Source } from "../plot/model";
import { wayToWrite, withNotes } from "../state/noteentries";
import type { Readiness } from "../state/readiness";
import { wayRows } from "../state/ways";
import { placeAt } from "../state/track";
import { createDetections, createLogBook, type TagTable } from "../ui/events";
import { createEntities } from "../ui/entities";
import { setText } from "../ui/dom";
import { utc } from "../ui/format";
import { createLinkLoss } from "../ui/linkloss";
import { createValues } from "../ui/values";
import { t } from "../words/words";
import type { Boxes } from "./boxes";
import type { PageHistory } from "./history";
import type { PagePresent } from "./present";
import { TagsOnMap } from "./tagsonmap";
import type { PageTime } from "./time";

/** Who looks, and what they may. */
export interface Rights {
  readonly me: string;
  readonly operator: boolean;
  readonly researcher: boolean;
}

export interface PanelNeeds {
  readonly boxes: Boxes;
  readonly map: FleetMap;
  readonly present: PagePresent;
  readonly history: PageHistory;
  readonly time: PageTime;
  readonly rights: Rights;
  /** The plots that the address asks for. */
  readonly plots: string;
  open(tab: "Plots" | "Control"): void;
  attention(): void;
  /** Other sources are plotted. */
  plotted(sources: readonly Source[]): void;
}

export type Panels = ReturnType<typeof createPanels>;

export function createPanels(needs: PanelNeeds) {
  const { boxes, map, present, history, time, rights } = needs;
  const { address } = present;
  const path = `/api/v1/vessels/${address}`;
  const name = (): string => present.name;
  const entity = (number: number): string => present.labels.get(number) ?? history.labels.get(number) ?? (number === 255 ? "" : String(number));
  const events = { at: (us: number | null): void => time.hover(us), pick: (us: number): void => time.pick(us), vessel: name, may: rights.researcher };
  const plots = createPlotsSoon(boxes.panels.Plots, address, rights.researcher, needs.plots, entity, plotHandlers(needs));
  const values = createValues(boxes.panels.Values, ({ update, field }) => {
    plots.add({ message: update.abbrev, entity: update.entity, field: field.name });
    needs.open("Plots");
  });
  const logBook = createLogBook(boxes.panels["Log book"], async (query, signal) => {
    const { entries, next } = await history.heeded(getJson<LogBook>(`${path}/logbook?${query}`, signal));
    return withNotes({ items: entries, next }, address, query, (question) => getJson<LogNotes>(`/api/v1/logbook?${question}`, signal));
  }, entity, events, rights.operator ? () => wayToWrite(address, time.atUs, placeNow(needs)) : undefined);
  const tagsOnMap = new TagsOnMap(map, () => tags.draw());
  const tags: TagTable = createDetections(boxes.panels.Tags, async (query, signal) => {
    const { detections, next } = await getJson<Detections>(`/api/v1/detections?vessel=${address}&flags=true&${query}`, signal);
    return { items: detections, next };
  }, ({ fromUs, toUs, open }) => `/api/v1/detections.csv?vessel=${address}&from_us=${fromUs}${open ? "" : `&to_us=${toUs}`}`, events, {
    shows: (one) => tagsOnMap.shows(one),
    changed({ items, next }) {
      tagsOnMap.update(items);
      const last = next ? items.at(-1) : undefined;
      setText(boxes.tagsCut, last ? t("Tags on the map: the newest {n}, since {time}. For older ones, see Tags.", { n: items.length, time: utc(last.time_us) }) : "");
    },
  });
  const route = createSeaRoute(map);
  const control = createControlSoon(boxes.control, {
    address,
    me: rights.me,
    may: rights.operator,
    steers: true,
    attention: needs.attention,
    name,
    pick: (told) => map.overlays.pick(told),
    mark: (place) => map.overlays.cursor(place ? { lat_deg: place[0], lon_deg: place[1] } : null),
    refusedOnMap: createRefused(map),
    drawRoute: (places) => (places ? route.update([], places) : route.clear()),
  });
  const parameters = createParametersLater(boxes.panels.Parameters, { address, me: rights.me, may: rights.operator, name, openControl: () => needs.open("Control") });
  const readiness = createMount(boxes.panels.Entities);
  const links = createMount(boxes.panels["Link loss"]);
  return { plots, values, readiness: (now: Readiness | null) => readiness(now && h(ReadinessList, now)), parts: createEntities(boxes.panels.Entities), links: (now: LinkStatus | undefined, linked: boolean) => links(h(LinkTable, { rows: wayRows(now, linked) })), logBook, tags, loss: createLinkLoss(boxes.loss, address, rights.operator), control, parameters };
}

/** Where the vessel is or was at the time that is told of; null where that is not known. */
function placeNow({ present, history, time }: PanelNeeds): { readonly lat_deg: number; readonly lon_deg: number } | null {
  if (time.atUs === null) return present.system?.fix ?? null;
  return placeAt(history.track, time.atUs, history.silences) ?? null;
}

function plotHandlers({ time, plotted }: PanelNeeds): PlotHandlers {
  return {
    pan: (part) => time.pan(part),
    scale: (factor) => time.scale(factor),
    cursor: (us) => time.hover(us, true),
    pick: (us) => time.pick(us),
    zoom: (fromUs, toUs) => time.choose({ fromUs: Math.round(fromUs), toUs: Math.round(toUs) }),
    changed: plotted,
  };
}
