// Which time a vessel's page tells of: the stretch that is shown, a replay within it, and the time that is pointed to.

import { ends, isLive, panned, type Range, zoomed } from "../plot/model";
import { advanced, type Playback, toggled, within, zoomedAbout } from "../replay/clock";

/** What is shown when nobody has chosen, µs. */
export const SPAN_US = 900_000_000;
/** A replay that ends so near to the present goes on with it, µs. */
const PRESENT_US = 5_000_000;
/** While it plays, the address is brought up to date so often, ms; and no step of it is longer. */
const ADDRESS_MS = 1_000;

export interface TimeHandlers {
  nowUs(): number;
  /** Another time is told of: what shows it is drawn with the next picture. */
  pointed(): void;
  /** Another stretch is shown; `fit`: all of it is to be brought into view. */
  ranged(fit: boolean): void;
  /** A replay began, went on, stood still or ended. */
  played(): void;
  /** The address is to tell what is looked at: at once, or when nobody drags any more. */
  remember(now: boolean): void;
}

export class PageTime {
  /** Null while the page follows the present. */
  play: Playback | null;
  range: Range;
  /** The time that is pointed to. */
  hoverUs: number | null = null;
  /** Whether a plot is pointed to, which has its cursor by itself. */
  byPlot = false;
  /** Counts plays, so that one that was ended for another does not go on beside it. */
  private run = 0;
  private readonly firstSpeed: number;

  constructor(private readonly on: TimeHandlers, { range, play }: { readonly range: Range; readonly play: Playback | null }) {
    [this.range, this.play, this.firstSpeed] = [range, play, play?.speed ?? 1];
  }

  /** The time of which map, plots and tables tell; null for the present. */
  get atUs(): number | null {
    return this.play?.playing ? this.play.atUs : (this.hoverUs ?? this.play?.atUs ?? null);
  }

  hover(us: number | null, plot = false): void {
    [this.hoverUs, this.byPlot] = [us, plot];
    this.on.pointed();
  }

  choose(next: Range, fit = true, told = true): void {
    this.range = next;
    const before = this.play;
    this.play = within(before, next, this.firstSpeed);
    if (!before !== !this.play) this.hoverUs = null;
    this.on.ranged(fit);
    this.on.remember(told);
  }

  /** A wheel turns faster than pictures are drawn, and than a browser lets its address be changed. */
  pan(part: number): void {
    this.choose(panned(this.range, part, this.on.nowUs()), true, false);
  }

  scale(factor: number): void {
    const { play, range } = this;
    this.choose(play && !isLive(range) ? zoomedAbout(range, play.atUs, factor, this.on.nowUs()) : zoomed(range, factor, this.on.nowUs()), true, false);
  }

  /** Stands still at a time of the range. */
  pick(us: number): void {
    const { fromUs, toUs } = ends(this.range, this.on.nowUs());
    if (isLive(this.range)) this.choose({ fromUs: Math.round(fromUs), toUs: Math.round(toUs) }, false);
    if (this.play) this.set(within({ ...this.play, atUs: us, playing: false }, this.range));
  }

  enter(): void {
    this.pick(ends(this.range, this.on.nowUs()).fromUs);
  }

  live(): void {
    const { fromUs, toUs } = ends(this.range, this.on.nowUs());
    this.choose({ spanUs: Math.min(SPAN_US, toUs - fromUs) });
  }

  toggle(): void {
    if (this.play) this.set(toggled(this.play, this.range));
  }

  seek(us: number): void {
    if (this.play) this.set(within({ ...this.play, atUs: us }, this.range), false);
  }

  step(byUs: number): void {
    if (this.play) this.set(within({ ...this.play, atUs: this.play.atUs + byUs, playing: false }, this.range), false);
  }

  speed(speed: number): void {
    if (this.play) this.set({ ...this.play, speed });
  }

  /** `told`: whether the address is told at once; while somebody drags, only in the end. */
  private set(next: Playback | null, told = true): void {
    const began = next?.playing && !this.play?.playing;
    [this.play, this.hoverUs] = [next, null];
    this.on.pointed();
    this.on.played();
    if (began) this.goOn(performance.now(), performance.now(), ++this.run);
    this.on.remember(told);
  }

  private goOn(beforeMs: number, savedMs: number, mine: number): void {
    requestAnimationFrame((ms) => {
      const { play, range } = this;
      if (!play?.playing || isLive(range) || mine !== this.run) return;
      const next = advanced(play, Math.min(ADDRESS_MS, ms - beforeMs), range.toUs);
      this.play = next;
      if (!next.playing && this.on.nowUs() - range.toUs < PRESENT_US) return this.live();
      this.on.pointed();
      const save = ms - savedMs > ADDRESS_MS || !next.playing;
      if (save) this.on.remember(true);
      this.goOn(ms, save ? ms : savedMs, mine);
    });
  }
}
