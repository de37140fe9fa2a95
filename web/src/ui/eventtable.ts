// A table of events of a stretch of time: the newest first, older ones by a button, all of them as CSV.

import { reason } from "../api/http";
import { type Event, HELD, type Identity, joined, type Known, lengthened, type Part, question, refreshed, type Stretch, within } from "../state/newest";
import { t } from "../words/words";
import { csv, save } from "./csv";
import { make, setAttribute, setText } from "./dom";
import { EventRows, type RowKind } from "./eventrows";
import { utc } from "./format";

/** Events that are asked for at once to be written into a file, which is the most. */
const FILE_PAGE = 10_000;
/** Those that came by themselves last: the history may not have them yet when it answers. */
const LATEST = 500;
/** A question for what was missed goes back so far before the last word of the server, µs. */
const BEFORE_US = 2_000_000;

export interface EventHandlers {
  /** The time of the row that is pointed to; null for none. */
  at(us: number | null): void;
  /** The time of the row that is chosen. */
  pick(us: number): void;
  /** Whose events these are. */
  vessel(): string;
  /** Whether they may be taken away. */
  readonly may: boolean;
}

export interface EventTable<T> {
  /** Asks for a stretch of time. Of another than before, only what was known of this one stays until the answer. */
  show(stretch: Stretch, goesOn: boolean, signal: AbortSignal): Promise<void>;
  /** The present goes on: asks only for what it knows that it lacks. */
  follow(stretch: Stretch, signal: AbortSignal): Promise<void>;
  /** Takes those that came by themselves, and leaves behind what is not in the stretch any more. */
  live(some: readonly T[], stretch: Stretch): void;
  /** Some may have come ashore since then (server's clock, µs since 1970 UTC) that did not come by themselves: asks for them. */
  missed(sinceUs: number, stretch: Stretch): void;
  /** Marks the last row at or before a time; null for none. */
  cursor(us: number | null): void;
  /** Redraws, after what is wanted of the events has changed. */
  draw(): void;
  /** Those that are in hand, and whether there are older ones. */
  readonly known: () => Part<T>;
}

/** A file that the page writes of what is wanted. */
export interface PageFile<T> {
  /** Heads of the columns, with units; the vessel comes before them. */
  readonly columns: readonly string[];
  record(one: T): readonly (string | number | null)[];
}

/** What a table is about. */
export interface Kind<T extends Event> extends Identity<T>, RowKind<T> {
  /** As in "the newest 2 of 3 …", and in the names of files. */
  readonly label: string;
  /** The same in the names of files, in no language but English. */
  readonly fileLabel: string;
  /** Heads of the columns. */
  readonly names: readonly string[];
  /** How all of a stretch is taken away: the address of the server's file, or a file that the page writes. */
  readonly file: ((stretch: Stretch) => string) | PageFile<T>;
  /** How many are shown at first, and more with each asking. */
  readonly page: number;
  ask(query: string, signal: AbortSignal): Promise<Part<T>>;
  /** Whether somebody wants to see it. */
  wanted(one: T): boolean;
  /** What to say of those that are shown; `cut` tells which part of the time they are of. */
  note(shown: number, all: number, cut: string): string;
  /** Called whenever what is in hand has changed. */
  changed(known: Part<T>): void;
}

export function eventTable<T extends Event>(root: HTMLElement, kind: Kind<T>, handlers: EventHandlers, ...extra: readonly HTMLElement[]): EventTable<T> {
  const events = new Events(root, kind, handlers, extra);
  return {
    show: (stretch, goesOn, signal) => events.show(stretch, goesOn, signal),
    follow: (stretch, signal) => events.follow(stretch, signal),
    live: (some, stretch) => events.live(some, stretch),
    missed: (sinceUs, stretch) => events.missed(sinceUs, stretch),
    cursor: (us) => events.rows.cursor(us),
    draw: () => events.draw(),
    known: () => events.inHand(),
  };
}

class Events<T extends Event> {
  readonly rows: EventRows<T>;
  private readonly note = make("p", { class: "dim", role: "status" });
  private readonly older = make("button", { type: "button", class: "older", hidden: "" }, t("Older ones"));
  private readonly take: HTMLElement;
  private known: Known<T> | undefined;
  /** What is in hand of the stretch that is asked for, while that is not known. */
  private meanwhile: readonly T[] = [];
  private trouble = "";
  private doing = "";
  private stop = new AbortController();
  private latest: readonly T[] = [];
  /** Since when something may be missing; null where nothing is. */
  private missingUs: number | null = null;
  /** The same, of what was missed while a question for it is under way; undefined while none is. */
  private meanwhileUs: number | null | undefined;

  constructor(root: HTMLElement, private readonly kind: Kind<T>, private readonly on: EventHandlers, extra: readonly HTMLElement[]) {
    const { label, names } = kind;
    this.rows = new EventRows(kind, label, names, this.older, (us) => on.at(us), (us) => on.pick(us));
    this.take = this.makeTake();
    root.append(make("div", { class: "row" }, ...extra, this.take, this.note), this.rows.box);
    this.older.addEventListener("click", () => void this.work(t("Fetching older ones …"), (of, signal) => this.lengthen(of, signal)));
  }

  inHand(): Part<T> {
    return this.known ?? { items: this.meanwhile, next: null };
  }

  async show(stretch: Stretch, goesOn: boolean, signal: AbortSignal): Promise<void> {
    const fresh = !goesOn || !this.known;
    if (fresh) this.begin(stretch);
    try {
      const part = await this.kind.ask(question(stretch, this.kind.page, null), signal);
      if (signal.aborted) return;
      this.known = refreshed(this.known, part, stretch, this.kind);
      [this.trouble, this.missingUs] = ["", null];
      this.join(this.latest, stretch);
    } catch (error) {
      if (signal.aborted) return;
      this.trouble = `${this.known ? t("Not brought up to date") : t("Not known")}: ${reason(error)}`;
    }
    if (fresh) this.doing = "";
    this.changed();
  }

  async follow(stretch: Stretch, signal: AbortSignal): Promise<void> {
    if (!this.known) return this.show(stretch, false, signal);
    if (this.join([], stretch)) this.changed();
    await this.catchUp(signal);
  }

  live(some: readonly T[], stretch: Stretch): void {
    this.latest = [...this.latest, ...some].slice(-LATEST);
    if (this.join(some, stretch)) this.changed();
  }

  missed(sinceUs: number, stretch: Stretch): void {
    this.join([], stretch);
    this.missingUs = Math.min(this.missingUs ?? sinceUs, sinceUs);
    if (this.meanwhileUs !== undefined) this.meanwhileUs = Math.min(this.meanwhileUs ?? sinceUs, sinceUs);
    void this.catchUp(this.stop.signal);
  }

  draw(): void {
    const { known, kind, trouble, older, take, note, rows } = this;
    const all = known?.items ?? this.meanwhile;
    const shown = all.filter(kind.wanted);
    const last = known?.next ? all.at(-1) : undefined;
    const cut = last ? t("The newest {n} of this time, since {time}.", { n: all.length, time: utc(last.time_us) }) : "";
    setText(note, [trouble || this.doing, known ? kind.note(shown.length, all.length, cut) : ""].filter(Boolean).join(" "));
    setAttribute(note, "class", trouble ? "bad-text" : "dim");
    setAttribute(older, "hidden", known?.next ? null : "");
    // Older ones may be wanted where none of these is.
    setAttribute(rows.box, "hidden", shown.length || known?.next ? null : "");
    setAttribute(take, "hidden", this.on.may && known && !trouble && all.length ? null : "");
    if (typeof kind.file === "function" && known) setAttribute(take, "href", kind.file(known.stretch));
    rows.fill(shown);
  }

  private changed(): void {
    this.draw();
    this.kind.changed(this.inHand());
  }

  /** How all of this time is taken away. */
  private makeTake(): HTMLElement {
    const { label, file } = this.kind;
    const whole = t("Download CSV of {label}", { label: label.toLowerCase() });
    if (typeof file === "function") return make("a", { class: "button", hidden: "", download: "", "aria-label": `${whole}, ${t("all of this time")}` }, "CSV");
    const button = make("button", { type: "button", hidden: "", "aria-label": `${whole} ${t("as shown, of all of this time")}` }, "CSV");
    button.addEventListener("click", () => void this.work(t("Fetching all of this time …"), (of, signal) => this.write(file, of, signal)));
    return button;
  }

  /** Another stretch is asked for: only what is known of that one stays until the answer. */
  private begin(stretch: Stretch): void {
    this.stop.abort();
    this.stop = new AbortController();
    this.meanwhile = within(this.known?.items ?? this.meanwhile, stretch);
    [this.known, this.trouble, this.doing] = [undefined, "", t("Fetching …")];
    this.changed();
  }

  /** Takes what lies in a stretch of what came by itself; whether that changed anything. */
  private join(some: readonly T[], stretch: Stretch): boolean {
    const { known, meanwhile, kind } = this;
    const before = known?.items ?? meanwhile;
    const next = joined(known ?? { items: meanwhile, next: null, stretch }, some, stretch, Math.max(HELD, before.length), kind);
    if (known) this.known = next;
    else this.meanwhile = next.items;
    return next.items !== before || (known !== undefined && known.next !== next.next);
  }

  /** Asks for what came ashore while nothing came by itself. */
  private async catchUp(signal: AbortSignal): Promise<void> {
    // One question at a time; what is missing then still is asked for with the next turn.
    if (!this.known || this.missingUs === null || this.meanwhileUs !== undefined) return;
    this.meanwhileUs = null;
    try {
      if (!(await this.askMissed(this.known, this.missingUs, signal))) return;
    } catch (error) {
      if (signal.aborted) return;
      this.trouble = t("Not brought up to date: {reason}", { reason: reason(error) });
    } finally {
      this.meanwhileUs = undefined;
    }
    this.changed();
  }

  /** Whether the answer is still wanted. */
  private async askMissed({ stretch }: Known<T>, sinceUs: number, signal: AbortSignal): Promise<boolean> {
    const { kind } = this;
    const part = await kind.ask(`${question(stretch, kind.page, null)}&received_since_us=${Math.max(0, sinceUs - BEFORE_US)}`, signal);
    if (signal.aborted || !this.known) return false;
    // More came than one answer holds: begin again with the newest.
    const whole = part.next ? await kind.ask(question(this.known.stretch, kind.page, null), signal) : undefined;
    if (signal.aborted || !this.known) return false;
    if (whole) this.known = refreshed(undefined, whole, this.known.stretch, kind);
    this.missingUs = this.meanwhileUs ?? null;
    [this.trouble, this.latest] = ["", [...this.latest, ...part.items].slice(-LATEST)];
    this.join(part.items, this.known.stretch);
    this.join(this.latest, this.known.stretch);
    return true;
  }

  /** One thing at a time: whoever asks for another stretch wants neither older ones nor a file of this one. */
  private async work(words: string, act: (of: Known<T>, signal: AbortSignal) => Promise<void>): Promise<void> {
    if (!this.known || this.doing) return;
    const { signal } = this.stop;
    [this.doing, this.trouble] = [words, ""];
    this.draw();
    let wrong = "";
    try {
      await act(this.known, signal);
    } catch (error) {
      wrong = reason(error);
    }
    if (signal.aborted) return;
    this.doing = "";
    if (wrong) setText(this.note, t("Not loaded: {wrong}", { wrong }));
    else this.draw();
  }

  private async lengthen(of: Known<T>, signal: AbortSignal): Promise<void> {
    const { kind, older } = this;
    const part = await kind.ask(question(of.stretch, kind.page, of.next), signal);
    if (signal.aborted || !this.known) return;
    const held = document.activeElement === older;
    const longer = lengthened(of, part, kind);
    // Newer ones may have come meanwhile.
    this.known = this.known === of ? longer : refreshed(longer, this.known, this.known.stretch, kind);
    this.changed();
    if (held && !this.known.next) this.rows.box.focus();
  }

  private async write({ columns, record }: PageFile<T>, of: Known<T>, signal: AbortSignal): Promise<void> {
    const all = await everything(this.kind, of.stretch, signal, (count) => setText(this.note, t("Fetching all of this time: {count} so far …", { count })));
    if (signal.aborted) return;
    const name = this.on.vessel();
    const text = csv(["vessel", ...columns], all.map((one) => [name, ...record(one)]));
    save(`${name} ${utc(of.stretch.fromUs)} to ${utc(of.stretch.toUs)} ${this.kind.fileLabel}.csv`.replaceAll(":", "").replaceAll(" ", "_"), text);
  }
}

/** Everything of a stretch that is wanted, page by page. */
async function everything<T extends Event>(kind: Kind<T>, stretch: Stretch, signal: AbortSignal, told: (count: number) => void): Promise<T[]> {
  const all: T[] = [];
  for (let part = await kind.ask(question(stretch, FILE_PAGE, null), signal); ; ) {
    for (const one of part.items) if (kind.wanted(one)) all.push(one);
    if (!part.next) return all;
    told(all.length);
    part = await kind.ask(question(stretch, FILE_PAGE, part.next), signal);
  }
}
