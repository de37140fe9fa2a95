// Other vessels beside the page's own: their tracks on its map and their lines in its plots, over the same time.

import { getJson, reason } from "../api/http";
import type { Entity, Recorded, Series, System, TrackPoint } from "../api/types.gen";
import type { FleetMap } from "../map/map";
import { type Companion, ends, isLive, type Range } from "../plot/model";
import { placeAt, Track } from "../state/track";
import { make, setAttribute, setText } from "../ui/dom";
import { hexAddress } from "../ui/format";
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

/** Who is beside, in `root`, with a way to change that; `go` is called with those who shall be. */
export function createBeside(root: HTMLElement, own: number, names: Readonly<Record<string, string>>, query: URLSearchParams, go: (addresses: readonly number[]) => void): Beside {
  const addresses = besideFrom(query, own);
  const all = [own, ...addresses];
  const tracks = new Map<number, { live: Track; shown: readonly TrackPoint[] }>(addresses.map((address) => [address, { live: new Track(), shown: [] }]));
  const ownName = make("span", {}, called(own, names));
  const legend = make("ul", { class: "legend", "aria-label": "Vessels in this view" });
  const problem = make("span", { class: "bad-text", role: "alert" });
  const more = make("button", { type: "button" }, "+ Vessel");
  const choice = make("select", { "aria-label": "Another vessel in this view", hidden: "" });
  const swatch = (index: number): HTMLElement => {
    const mark = make("i", { class: "swatch" });
    mark.style.borderTopColor = `var(--series-${index + 1})`;
    return mark;
  };
  if (addresses.length) legend.append(make("li", {}, swatch(0), ownName));
  addresses.forEach((address, index) => {
    const name = called(address, names);
    const remove = make("button", { type: "button", class: "small", "aria-label": `Remove ${name} from this view` }, "✕");
    remove.addEventListener("click", () => go(addresses.filter((one) => one !== address)));
    legend.append(make("li", {}, swatch(index + 1), make("a", { href: `/vessels/${address}` }, name), remove));
  });
  more.addEventListener("click", () => void offer());
  choice.addEventListener("change", () => choice.value && go([...addresses, Number(choice.value)]));
  if (addresses.length >= MOST) more.hidden = true;
  root.append(...(addresses.length ? [legend] : []), more, choice, problem);

  /** Offers every vessel of which places are recorded. */
  const offer = async (): Promise<void> => {
    setText(problem, "");
    try {
      const recorded = await getJson<Recorded[]>("/api/v1/recorded");
      const known = new Set(recorded.filter(({ abbrev }) => abbrev === "EstimatedState").map(({ system }) => system));
      const others = [...known].filter((address) => !all.includes(address)).map((address) => ({ address, name: called(address, names) }));
      if (!others.length) return setText(problem, "No place of any other vessel is recorded.");
      others.sort((one, other) => one.name.localeCompare(other.name));
      choice.replaceChildren(make("option", { value: "" }, "Which vessel?"), ...others.map(({ address, name }) => make("option", { value: String(address) }, name)));
      more.hidden = true;
      setAttribute(choice, "hidden", null);
      choice.focus();
    } catch (error) {
      setText(problem, reason(error));
    }
  };

  return {
    addresses,
    colours: addresses.length ? all : [],
    learn: () =>
      Promise.all(
        addresses.map(async (address) => {
          const [series, entities] = await Promise.all([
            getJson<Series[]>(`/api/v1/series?system=${address}`),
            getJson<Entity[]>(`/api/v1/vessels/${address}/entities`),
          ]);
          return { address, name: called(address, names), series, labels: labelsThen(entities, Infinity) };
        }),
      ),
    async ask(range, nowUs, signal) {
      const { fromUs, toUs } = ends(range, nowUs);
      const time = `points=${POINTS}&from_us=${Math.max(0, Math.round(fromUs))}&to_us=${Math.round(toUs) + 1}`;
      await Promise.all(
        [...tracks].map(async ([address, track]) => {
          try {
            const points = await getJson<TrackPoint[]>(`/api/v1/vessels/${address}/track?${time}`, signal);
            track.live.recorded(points);
            track.shown = isLive(range) ? track.live.all() : points;
            setText(problem, "");
          } catch (error) {
            if (!signal.aborted) setText(problem, `${called(address, names)}: ${reason(error)}`);
          }
        }),
      );
    },
    draw(map, play, systems) {
      return addresses.flatMap((address) => {
        const [track, system] = [tracks.get(address), systems.get(address)];
        const name = names[String(address)] ?? system?.name ?? null;
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
    },
    name: (own) => setText(ownName, own),
  };
}
