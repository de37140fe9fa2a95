// Other vessels beside the page's own: their tracks on its map and their lines in its plots, over the same time.

import { getJson, reason } from "../api/http";
import type { Entity, Recorded, Series, System, TrackPoint } from "../api/types.gen";
import type { FleetMap } from "../map/map";
import { type Companion, ends, isLive, type Range } from "../plot/model";
import { placeAt, Track } from "../state/track";
import { make, setAttribute, setText } from "../ui/dom";
import { hexAddress } from "../ui/format";
import { t } from "../words/words";
import type { Playback } from "./clock";
import { labelsThen, systemThen } from "./then";

/** As many as there are colours that are told apart, without the page's own. */
const MOST = 3;
const POINTS = 5_000;

export interface Beside {
  /** Who they are, in the order of their colours. */
  readonly addresses: readonly number[];
  /** All vessels in the view in the order of their colours; empty when there is only the page's own. */
  readonly colours: readonly number[];
  /** What is recorded of them. */
  learn(): Promise<Companion[]>;
  /** Asks where they were. */
  ask(range: Range, nowUs: number, signal: AbortSignal): Promise<void>;
  /** Draws their tracks, and tells where they are or were. */
  draw(map: FleetMap, play: Playback | null, systems: ReadonlyMap<number, System>): System[];
  /** `own`: what the page's own vessel is called. */
  name(own: string): void;
}

/** The vessels that an address asks for beside `own`. */
export function besideFrom(query: URLSearchParams, own: number): number[] {
  const asked = (query.get("with") ?? "").split(",").filter((text) => /^\d{1,5}$/.test(text)).map(Number);
  return [...new Set(asked)].filter((address) => address !== own && address < 0xffff).slice(0, MOST);
}

/** A vessel's name, as people gave it, or else its address. */
function called(address: number, names: Readonly<Record<string, string>>): string {
  return names[String(address)] ?? hexAddress(address);
}

type Go = (addresses: readonly number[]) => void;

/** Who is beside, in `root`, with a way to change that; `go` is called with those who shall be. */
export function createBeside(root: HTMLElement, own: number, names: Readonly<Record<string, string>>, query: URLSearchParams, go: Go): Beside {
  return new Others(root, own, names, besideFrom(query, own), go);
}

class Others implements Beside {
  readonly colours: readonly number[];
  private readonly tracks: ReadonlyMap<number, { live: Track; shown: readonly TrackPoint[] }>;
  private readonly ownName: HTMLElement;
  private readonly problem = make("span", { class: "bad-text", role: "alert" });
  private readonly more = make("button", { type: "button" }, t("+ Vessel"));
  private readonly choice = make("select", { "aria-label": t("Another vessel in this view"), hidden: "" });

  constructor(root: HTMLElement, private readonly own: number, private readonly names: Readonly<Record<string, string>>, readonly addresses: readonly number[], private readonly go: Go) {
    const { more, choice, problem } = this;
    this.colours = addresses.length ? [own, ...addresses] : [];
    this.tracks = new Map(addresses.map((address) => [address, { live: new Track(), shown: [] }]));
    this.ownName = make("span", {}, called(own, names));
    more.addEventListener("click", () => void this.offer());
    choice.addEventListener("change", () => choice.value && go([...addresses, Number(choice.value)]));
    more.hidden = addresses.length >= MOST;
    root.append(...(addresses.length ? [this.legend()] : []), more, choice, problem);
  }

  learn(): Promise<Companion[]> {
    const one = async (address: number): Promise<Companion> => {
      const [series, entities] = await Promise.all([
        getJson<Series[]>(`/api/v1/series?system=${address}`),
        getJson<Entity[]>(`/api/v1/vessels/${address}/entities`),
      ]);
      return { address, name: called(address, this.names), series, labels: labelsThen(entities, Infinity) };
    };
    return Promise.all(this.addresses.map(one));
  }

  async ask(range: Range, nowUs: number, signal: AbortSignal): Promise<void> {
    const { fromUs, toUs } = ends(range, nowUs);
    const time = `points=${POINTS}&from_us=${Math.max(0, Math.round(fromUs))}&to_us=${Math.round(toUs) + 1}`;
    const one = async (address: number, track: { live: Track; shown: readonly TrackPoint[] }): Promise<void> => {
      try {
        const points = await getJson<TrackPoint[]>(`/api/v1/vessels/${address}/track?${time}`, signal);
        track.live.recorded(points);
        track.shown = isLive(range) ? track.live.all() : points;
        setText(this.problem, "");
      } catch (error) {
        if (!signal.aborted) setText(this.problem, `${called(address, this.names)}: ${reason(error)}`);
      }
    };
    await Promise.all([...this.tracks].map(([address, track]) => one(address, track)));
  }

  draw(map: FleetMap, play: Playback | null, systems: ReadonlyMap<number, System>): System[] {
    return this.addresses.flatMap((address) => {
      const [track, system] = [this.tracks.get(address), systems.get(address)];
      const name = this.names[String(address)] ?? system?.name ?? null;
      if (!track) return [];
      if (play) {
        const place = placeAt(track.shown, play.atUs);
        map.track(address, track.shown, play.atUs);
        return place ? [systemThen(address, name, new Map(), place, play.atUs)] : [];
      }
      if (system?.fix && track.live.add(system.fix)) track.shown = track.live.all();
      map.track(address, track.shown);
      return system ? [{ ...system, name }] : [];
    });
  }

  name(own: string): void {
    setText(this.ownName, own);
  }

  private legend(): HTMLElement {
    const { addresses, names } = this;
    const rows = addresses.map((address, index) => {
      const name = called(address, names);
      const remove = make("button", { type: "button", class: "small", "aria-label": t("Remove {name} from this view", { name }) }, "✕");
      remove.addEventListener("click", () => this.go(addresses.filter((one) => one !== address)));
      return make("li", {}, swatch(index + 1), make("a", { href: `/vessels/${address}` }, name), remove);
    });
    return make("ul", { class: "legend", "aria-label": t("Vessels in this view") }, make("li", {}, swatch(0), this.ownName), ...rows);
  }

  /** Offers every vessel of which places are recorded. */
  private async offer(): Promise<void> {
    const { problem, choice, more, names } = this;
    setText(problem, "");
    try {
      const recorded = await getJson<Recorded[]>("/api/v1/recorded");
      const known = new Set(recorded.filter(({ abbrev }) => abbrev === "EstimatedState").map(({ system }) => system));
      const others = [...known].filter((address) => address !== this.own && !this.addresses.includes(address)).map((address) => ({ address, name: called(address, names) }));
      if (!others.length) return setText(problem, t("No place of any other vessel is recorded."));
      others.sort((one, other) => one.name.localeCompare(other.name));
      choice.replaceChildren(make("option", { value: "" }, t("Which vessel?")), ...others.map(({ address, name }) => make("option", { value: String(address) }, name)));
      more.hidden = true;
      setAttribute(choice, "hidden", null);
      choice.focus();
    } catch (error) {
      setText(problem, reason(error));
    }
  }
}

function swatch(index: number): HTMLElement {
  const mark = make("i", { class: "swatch" });
  mark.style.borderTopColor = `var(--series-${index + 1})`;
  return mark;
}
