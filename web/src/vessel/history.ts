// What a vessel's page knows of the past: its track, its silences, what is recorded, and when the history is asked again.

import { getJson } from "../api/http";
import type { Entity, Gap, LinkStatus, Series, TrackPoint } from "../api/types.gen";
import { ends, isLive, type Range, type Source } from "../plot/model";
import { labelsThen } from "../replay/then";
import { Behind } from "../state/behind";
import type { Stretch } from "../state/newest";
import { Track } from "../state/track";
import type { Labels } from "../state/vitals";

/** What the history has beyond what came by itself, and the link, are looked after so often while the present is followed, ms. */
const AGAIN_MS = 5_000;
const SETTLE_MS = 200;
const POINTS = 5_000;
/** What is older than the stretch is left out when it is so much of it: with each change of the begin all is drawn again. */
const OLDER = 0.05;

export interface HistoryHandlers {
  nowUs(): number;
  range(): Range;
  /** The track has come; `fit`: it is to be brought into view. */
  tracked(fit: boolean): void;
  /** The tables ask for their part; with `goesOn` only for what they lack of the same stretch. */
  tables(stretch: Stretch, goesOn: boolean, signal: AbortSignal): Promise<unknown>;
  /** The present goes on, and nothing is missing but what tables know that they lack. */
  follow(stretch: Stretch, signal: AbortSignal): Promise<unknown>;
  /** All of another stretch is there. */
  done(fit: boolean, signal: AbortSignal): void;
}

export class PageHistory {
  track: readonly TrackPoint[] = [];
  catalogue: readonly Series[] = [];
  silences: readonly Gap[] = [];
  named: readonly Entity[] = [];
  /** As the history knows them. */
  labels: Labels = new Map();
  link: LinkStatus | undefined;
  readonly behind = new Behind();
  private readonly ahead = new Track();
  /** The track while it follows the present. */
  private followed: TrackPoint[] = [];
  private settle: number | undefined;
  private asked = new AbortController();
  /** The range that was asked for last. */
  private askedRange: Range | undefined;

  constructor(private readonly path: string, private readonly address: number, private readonly on: HistoryHandlers) {}

  /** What the history did not answer is asked again. */
  heeded<T>(answer: Promise<T>): Promise<T> {
    return answer.catch((error: unknown) => {
      this.behind.failed();
      throw error;
    });
  }

  stretch(): Stretch {
    const { fromUs, toUs } = ends(this.on.range(), this.on.nowUs());
    return { fromUs: Math.max(0, Math.round(fromUs)), toUs: Math.round(toUs) + 1, open: isLive(this.on.range()) };
  }

  /** A place came by itself; whether the track that is shown grew. */
  grew(fix: Parameters<Track["add"]>[0]): boolean {
    if (!this.ahead.add(fix) || !isLive(this.on.range())) return false;
    const { fromUs, toUs } = ends(this.on.range(), this.on.nowUs());
    const all = this.ahead.all();
    const newest = all.at(-1);
    const isOld = (this.followed[0]?.time_us ?? 0) < fromUs - OLDER * (toUs - fromUs);
    if (newest && this.track === this.followed && !isOld && this.followed.length < all.length) this.followed.push(newest);
    else this.track = this.followed = all.filter((point) => point.time_us >= fromUs);
    return true;
  }

  /** Asks soon: whoever drags does not ask at each step. */
  soon(fit: boolean): void {
    window.clearTimeout(this.settle);
    this.settle = window.setTimeout(() => void this.ask(fit), SETTLE_MS);
  }

  async ask(fit = true): Promise<void> {
    this.asked.abort();
    this.asked = new AbortController();
    const { signal } = this.asked;
    const [stretch, range] = [this.stretch(), this.on.range()];
    const goesOn = isLive(range) && this.askedRange === range;
    this.askedRange = range;
    if (goesOn && !this.behind.due(this.on.nowUs())) {
      await this.on.follow(stretch, signal);
      return this.again(signal);
    }
    this.behind.asked(this.on.nowUs());
    await Promise.all([this.askTrack(stretch, fit, signal), this.on.tables(stretch, goesOn, signal)]);
    this.on.done(fit, signal);
    this.again(signal);
  }

  private async askTrack({ fromUs, toUs }: Stretch, fit: boolean, signal: AbortSignal): Promise<void> {
    try {
      const points = await this.heeded(getJson<TrackPoint[]>(`${this.path}/track?points=${POINTS}&from_us=${fromUs}&to_us=${toUs}`, signal));
      this.ahead.recorded(points);
      this.track = isLive(this.on.range()) ? this.ahead.all() : points;
      this.on.tracked(fit);
    } catch {
      // The track that is known stays; the tables tell that the history does not answer.
    }
  }

  private again(signal: AbortSignal): void {
    window.clearTimeout(this.settle);
    if (isLive(this.on.range()) && !signal.aborted) this.settle = window.setTimeout(() => void this.ask(), AGAIN_MS);
  }

  /** Learns what is recorded, which parts the vessel has, and when it was silent. */
  async learn(): Promise<void> {
    const now = this.on.nowUs();
    const [series, gaps, entities] = await Promise.all([
      getJson<Series[]>(`/api/v1/series?system=${this.address}`),
      getJson<Gap[]>(`${this.path}/gaps?from_us=0&to_us=${Math.round(now)}`),
      getJson<Entity[]>(`${this.path}/entities`),
    ]);
    [this.catalogue, this.silences, this.named] = [series, gaps, entities];
    this.labels = labelsThen(entities, Infinity);
  }

  /** When the last of all that is recorded was said, µs; 0 for never. */
  lastUs(): number {
    return Math.max(0, ...this.catalogue.map((one) => one.last_us ?? 0));
  }

  /** All that is recorded; undefined where nothing is. */
  whole(): { readonly fromUs: number; readonly toUs: number } | undefined {
    const [firsts, lasts] = [this.catalogue.flatMap((one) => one.first_us ?? []), this.catalogue.flatMap((one) => one.last_us ?? [])];
    return firsts.length ? { fromUs: Math.min(...firsts), toUs: Math.max(...lasts) + 1_000_000 } : undefined;
  }

  /** The series of a message, two at most, to begin with. */
  sources(message: string, field: string, live: Iterable<{ readonly abbrev: string; readonly entity: number }>): Source[] {
    const found = new Map<string, Source>();
    for (const one of this.catalogue) if (one.message === message) found.set(String(one.entity), { message, entity: one.entity, field });
    for (const one of live) if (one.abbrev === message) found.set(String(one.entity), { message, entity: one.entity, field });
    return [...found.values()].slice(0, 2);
  }

  /** Looks after the link, again and again. */
  async watchLink(): Promise<void> {
    try {
      this.link = (await getJson<LinkStatus[]>("/api/v1/links")).find((one) => one.vessel === this.address);
      this.behind.backlog(this.link?.backlog_records ?? 0);
    } catch {
      this.link = undefined;
    }
    window.setTimeout(() => void this.watchLink(), AGAIN_MS);
  }
}
