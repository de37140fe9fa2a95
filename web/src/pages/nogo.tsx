// No-go areas: a map, the list of them, and the form of one that is drawn on the map.

import { effect, signal } from "@preact/signals";
import { render } from "preact";
import { toLonLat } from "ol/proj";
import { inEnglish, patchJson, reason, Refusal } from "../api/http";
import { resource } from "../api/resource";
import { postUntilAnswered } from "../api/retry";
import type { NoGoArea, NoGoAreaChange, NoGoAreaRequest, NoGoAreas, NoGoAreasRequest, PlanPlace } from "../api/types.gen";
import { createNoGoFile } from "../components/nogofile";
import { NoGoForm } from "../components/nogoform";
import { NoGoList } from "../components/nogolist";
import { createMap, type FleetMap } from "../map/map";
import { createSeaRoute } from "../map/searoute";
import { Corners } from "../state/corners";
import { type AreaDraft, areaAsk, cornersOf, EMPTY_AREA } from "../state/nogo";
import { fieldOf, type Wrong } from "../state/notes";
import { Keys } from "../state/sending";
import { newKey } from "../state/window";
import { createChrome } from "../ui/chrome";
import { make } from "../ui/dom";
import { t } from "../words/words";

/** The chart takes an area before the server answers. */
const PATIENCE_MS = 30_000;
/** For so long an area that nobody answers is sent again by itself, ms. */
const SENT_WITHIN_MS = 120_000;
/** What others did comes after so long at most, ms. */
const AGAIN_MS = 20_000;
/** Areas that the server closes at a time. */
const MOST_CLOSED = 200;
const LIST = "/api/v1/no-go-areas?lifted=true";

/** What is in the form: a new area, or one that is changed. */
type Editing = { readonly of: NoGoArea | undefined };

/** Why a file of areas is not taken, and which of them is meant. */
function ofFile(error: unknown): string {
  const number = error instanceof Refusal ? error.why.says?.values["area"] : undefined;
  return number === undefined ? reason(error) : t("Area {number}: {why}", { number, why: reason(error) });
}

class NoGoPage {
  private readonly list = resource<NoGoAreas>();
  private readonly editing = signal<Editing | undefined>(undefined);
  private readonly corners = new Corners();
  private readonly busy = signal(false);
  private readonly wrong = signal("");
  /** The one that was lifted just now. */
  private readonly lifted = signal<NoGoArea | undefined>(undefined);
  private readonly keys = new Keys<NoGoAreaRequest | NoGoAreasRequest>(newKey);
  private readonly File = createNoGoFile({ close: (areas, waits) => this.closeAll(areas, waits), room: () => this.room() });
  private readonly map: FleetMap;
  private fits = true;

  constructor(root: HTMLElement) {
    const box = make("div", { class: "map", tabindex: "0", role: "application", "aria-label": t("Map of the closed areas. Arrow keys move it, plus and minus zoom; the list has the same.") });
    const side = make("div", { class: "nogo-side" });
    root.replaceChildren(make("div", { class: "nogo-body" }, make("div", { class: "map-box" }, box), side));
    this.map = createMap(box);
    const drawn = createSeaRoute(this.map, { moved: (index, place, done) => this.corners.move(index, place, done), pulled: (side, place) => this.corners.insert(side, place), label: (index) => String(index + 1) });
    effect(() => {
      const corners = this.editing.value ? this.corners.now.value : [];
      drawn.update(corners, closedRing(corners));
    });
    this.map.clicks.claim("edit", ({ coordinate }) => {
      if (!this.editing.value) return false;
      this.corners.add(placeOf(coordinate));
      return true;
    });
    render(<this.Side />, side);
    createChrome({ messages: ["VehicleState"], events: false, every_ms: 500 }, {});
    void this.ask();
    window.setInterval(() => {
      if (!document.hidden && !this.list.busy.value && !this.busy.value) void this.ask();
    }, AGAIN_MS);
  }

  private readonly Side = () => {
    const { list, editing, busy, wrong, lifted } = this;
    const known = list.value.value;
    const act = { show: ({ area }: NoGoArea) => this.map.noGo.fit(area), edit: (area: NoGoArea) => this.edit(area), close: (area: NoGoArea, closed: boolean) => void this.close(area, closed) };
    return (
      <>
        {known?.trouble && known.areas.some((area) => area.lifted === null) && <p class="note bad" role="alert">{t("Not in force: {trouble}", { trouble: known.trouble })}</p>}
        {known?.may_change && !editing.value && <p><button type="button" class="main" onClick={() => this.edit(undefined)}>{t("Close an area")}</button></p>}
        {known?.may_change && !editing.value && <this.File />}
        {editing.value && <this.Form of={editing.value.of} />}
        <p role="status">{lifted.value && <>{t("{name} is lifted: vessels may enter it.", { name: lifted.value.area.name })} <button type="button" onClick={() => lifted.value && void this.close(lifted.value, true)}>{t("Undo")}</button></>}</p>
        {wrong.value && <p class="note bad" role="alert">{wrong.value}</p>}
        {list.trouble.value && <p class="bad-text" role="alert">{list.trouble.value} <button type="button" onClick={() => void this.ask()}>{t("Try again")}</button></p>}
        {known && !editing.value && <NoGoList areas={known.areas} mayChange={known.may_change} busy={busy.value} act={act} />}
        <p class="dim">{t("Closed areas bind all vessels: plans and routes through them are refused, and vessels keep out by the sea chart aboard, which they fetch when they have a link.")}</p>
      </>
    );
  };

  private readonly Form = ({ of }: Editing) => (
    <NoGoForm
      key={of?.id ?? 0}
      draft={of ? { name: of.area.name, reason: of.area.reason } : EMPTY_AREA}
      corners={this.corners}
      title={of ? t("Change {name}", { name: of.area.name }) : t("Close an area")}
      save={of ? t("Save") : t("Close this area")}
      centre={() => placeOf(this.map.ol.getView().getCenter() ?? [0, 0])}
      show={() => this.map.noGo.fit(areaAsk(EMPTY_AREA, this.corners.now.value))}
      send={(draft, waits) => this.send(of, draft, waits)}
      cancel={() => (this.editing.value = undefined)}
    />
  );

  private edit(area: NoGoArea | undefined): void {
    [this.lifted.value, this.wrong.value] = [undefined, ""];
    this.corners.begin(area ? cornersOf(area) : []);
    this.editing.value = { of: area };
    if (area) this.map.noGo.fit(area.area);
  }

  private async ask(): Promise<void> {
    const found = await this.list.ask(LIST);
    if (!found) return;
    const closed = found.areas.filter(({ lifted }) => lifted === null);
    this.map.noGo.show(closed);
    const [first] = closed;
    if (this.fits && first) this.map.noGo.fit(first.area);
    this.fits = false;
  }

  private async send(of: NoGoArea | undefined, draft: AreaDraft, waits: (tries: number) => void): Promise<Wrong | undefined> {
    const area = areaAsk(draft, this.corners.now.value);
    try {
      if (of) await this.change(of, { revision: of.revision, area, closed: true });
      else await this.post("", area, waits);
      this.editing.value = undefined;
      await this.ask();
      return undefined;
    } catch (error) {
      if (of && error instanceof Refusal && error.status === 409) return this.takeUp(of);
      return fieldOf(reason(error), inEnglish(error));
    }
  }

  /** Somebody else changed it meanwhile: what is in the form stays, and would replace what they made of it. */
  private async takeUp(of: NoGoArea): Promise<Wrong> {
    await this.ask();
    const now = this.list.value.value?.areas.find(({ id }) => id === of.id);
    if (now) this.editing.value = { of: now };
    const { by } = now?.lifted ?? now?.changed ?? { by: "?" };
    const text = now?.lifted ? t("{by} lifted it meanwhile. Save closes it again as it is here.", { by }) : t("{by} changed it meanwhile, as the map shows. Save replaces that by what is here.", { by });
    return { field: "form", text };
  }

  private room(): number {
    return MOST_CLOSED - (this.list.value.value?.areas.filter(({ lifted }) => lifted === null).length ?? 0);
  }

  /** Closes those of a file; why not, or nothing where it is done. */
  private async closeAll(areas: readonly NoGoAreaRequest[], waits: (tries: number) => void): Promise<string> {
    const why = await this.post("/batch", { areas: [...areas] }, waits).then(() => "", ofFile);
    await this.ask();
    return why;
  }

  /** What is sent again because nobody answered is closed once. */
  private async post(path: "" | "/batch", body: NoGoAreaRequest | NoGoAreasRequest, waits: (tries: number) => void): Promise<void> {
    const query = new URLSearchParams({ key: this.keys.of(body).key });
    await postUntilAnswered(() => `/api/v1/no-go-areas${path}?${query}`, PATIENCE_MS, SENT_WITHIN_MS, body, waits);
    this.keys.answered();
  }

  /** Lifts an area, or closes it again. */
  private async close(area: NoGoArea, closed: boolean): Promise<void> {
    [this.busy.value, this.wrong.value, this.lifted.value] = [true, "", undefined];
    try {
      const changed = await this.change(area, { revision: area.revision, area: area.area, closed });
      if (!closed) this.lifted.value = changed;
    } catch (error) {
      this.wrong.value = reason(error);
    }
    await this.ask();
    this.busy.value = false;
  }

  private change({ id }: NoGoArea, change: NoGoAreaChange): Promise<NoGoArea> {
    return patchJson<NoGoArea>(`/api/v1/no-go-areas/${id}`, change, PATIENCE_MS);
  }
}

export function startNoGo(root: HTMLElement): void {
  new NoGoPage(root);
}

function placeOf(coordinate: readonly number[]): PlanPlace {
  const [lon_deg = 0, lat_deg = 0] = toLonLat([...coordinate]);
  return { lat_deg, lon_deg };
}

/** The border that corners have, back to the first of them; none while there are too few. */
function closedRing(corners: readonly PlanPlace[]): readonly PlanPlace[] {
  return corners.length > 2 ? [...corners, ...corners.slice(0, 1)] : [];
}
