// A table of events of a stretch of time: the newest first, older ones by a button, all of them as CSV.

import { reason } from "../api/http";
import { type Event, HELD, type Identity, joined, type Known, lengthened, type Part, question, refreshed, type Stretch, within } from "../state/newest";
import { csv, save } from "./csv";
import { make, setAttribute, setText } from "./dom";
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
  /** Draws anew, after what is wanted of the events has changed. */
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
export interface Kind<T extends Event> extends Identity<T> {
  /** As in "the newest 2 of 3 …", and in the names of files. */
  readonly label: string;
  /** Heads of the columns. */
  readonly names: readonly string[];
  /** How all of a stretch is taken away: the address of the server's file, or a file that the page writes. */
  readonly file: ((stretch: Stretch) => string) | PageFile<T>;
  /** How many are shown at first, and more with each asking. */
  readonly page: number;
  ask(query: string, signal: AbortSignal): Promise<Part<T>>;
  cells(one: T): readonly string[];
  /** Further marks of its row. */
  marks(one: T): Readonly<Record<string, string>>;
  /** Of the second cell. */
  tag?(one: T): string;
  /** Whether somebody wants to see it. */
  wanted(one: T): boolean;
  /** What to say of those that are shown; `cut` tells which part of the time they are of. */
  note(shown: number, all: number, cut: string): string;
  /** Called whenever what is in hand has changed. */
  changed(known: Part<T>): void;
}

export function eventTable<T extends Event>(root: HTMLElement, kind: Kind<T>, { at, pick, vessel, may }: EventHandlers, ...extra: readonly HTMLElement[]): EventTable<T> {
  const { label, names } = kind;
  const note = make("p", { class: "dim", role: "status" });
  const { file } = kind;
  const whole = `Download CSV of ${label.toLowerCase()}`;
  const take =
    typeof file === "function"
      ? make("a", { class: "button", hidden: "", download: "", "aria-label": `${whole}, all of this time` }, "CSV")
      : make("button", { type: "button", hidden: "", "aria-label": `${whole} as shown, of all of this time` }, "CSV");
  const older = make("button", { type: "button", class: "older", hidden: "" }, "Older ones");
  const head = make("tr");
  for (const name of names) head.append(make("th", { scope: "col" }, name));
  const body = make("tbody");
  const box = make("div", { class: "wide scroll", tabindex: "0", role: "region", "aria-label": label }, make("table", { class: "compact" }, make("thead", {}, head), body), older);
  root.append(make("div", { class: "row" }, ...extra, take, note), box);
  listen(body, box, at, pick);

  let known: Known<T> | undefined;
  /** What is in hand of the stretch that is asked for, while that is not known. */
  let meanwhile: readonly T[] = [];
  let trouble = "";
  let doing = "";
  let stop = new AbortController();
  let shown: readonly T[] = [];
  let drawn: readonly T[] | undefined;
  let latest: readonly T[] = [];
  /** Since when something may be missing; null where nothing is. */
  let missingUs: number | null = null;
  /** The same, of what was missed while a question for it is under way; undefined while none is. */
  let meanwhileUs: number | null | undefined;
  let cursorUs: number | null = null;

  const mark = (): void => {
    // The newest comes first.
    const index = cursorUs === null ? -1 : shown.findIndex(({ time_us }) => time_us <= (cursorUs ?? 0));
    [...body.children].forEach((row, number) => setAttribute(row, "aria-current", number === index ? "time" : null));
  };
  /** Rows that stay are not touched: one of them may have the focus, or be read. */
  let rows = new Map<string, { readonly one: T; readonly element: HTMLElement }>();
  const fill = (wanted: readonly T[]): void => {
    const rowOf = (one: T): { readonly one: T; readonly element: HTMLElement } => {
      const before = rows.get(kind.key(one));
      return before?.one === one ? before : { one, element: row(one, kind) };
    };
    const next = new Map(wanted.map((one) => [kind.key(one), rowOf(one)]));
    for (const [key, { element }] of rows) if (next.get(key)?.element !== element) element.remove();
    let at = body.firstElementChild;
    for (const { element } of next.values()) {
      if (element === at) at = at.nextElementSibling;
      else body.insertBefore(element, at);
    }
    rows = next;
  };
  const draw = (): void => {
    const all = known?.items ?? meanwhile;
    shown = all.filter(kind.wanted);
    const last = known?.next ? all.at(-1) : undefined;
    const cut = last ? `The newest ${all.length} of this time, since ${utc(last.time_us)}.` : "";
    setText(note, [trouble || doing, known ? kind.note(shown.length, all.length, cut) : ""].filter(Boolean).join(" "));
    setAttribute(note, "class", trouble ? "bad-text" : "dim");
    setAttribute(older, "hidden", known?.next ? null : "");
    // Older ones may be wanted where none of these is.
    setAttribute(box, "hidden", shown.length || known?.next ? null : "");
    setAttribute(take, "hidden", may && known && !trouble && all.length ? null : "");
    if (typeof file === "function" && known) setAttribute(take, "href", file(known.stretch));
    const before = drawn;
    if (before?.length !== shown.length || shown.some((one, at) => one !== before[at])) {
      drawn = shown;
      fill(shown);
    }
    mark();
  };
  const changed = (): void => {
    draw();
    kind.changed(known ?? { items: meanwhile, next: null });
  };
  /** Takes what lies in a stretch of what came by itself; whether that changed anything. */
  const join = (some: readonly T[], stretch: Stretch): boolean => {
    const before = known?.items ?? meanwhile;
    const next = joined(known ?? { items: meanwhile, next: null, stretch }, some, stretch, Math.max(HELD, before.length), kind);
    const cut = known?.next !== next.next;
    if (known) known = next;
    else meanwhile = next.items;
    return next.items !== before || (known !== undefined && cut);
  };
  /** Asks for what came ashore while nothing came by itself. */
  const catchUp = async (signal: AbortSignal): Promise<void> => {
    const [of, sinceUs] = [known, missingUs];
    // One question at a time; what is missing then still is asked for with the next turn.
    if (!of || sinceUs === null || meanwhileUs !== undefined) return;
    meanwhileUs = null;
    try {
      const part = await kind.ask(`${question(of.stretch, kind.page, null)}&came_from_us=${Math.max(0, sinceUs - BEFORE_US)}`, signal);
      if (signal.aborted || !known) return;
      // More came than one answer holds: begin again with the newest.
      const anew = part.next ? await kind.ask(question(known.stretch, kind.page, null), signal) : undefined;
      if (signal.aborted) return;
      if (anew) known = refreshed(undefined, anew, known.stretch, kind);
      missingUs = meanwhileUs ?? null;
      [trouble, latest] = ["", [...latest, ...part.items].slice(-LATEST)];
      join(part.items, known.stretch);
      join(latest, known.stretch);
    } catch (error) {
      if (signal.aborted) return;
      trouble = `Not brought up to date: ${reason(error)}`;
    } finally {
      meanwhileUs = undefined;
    }
    changed();
  };
  /** One thing at a time: whoever asks for another stretch wants neither older ones nor a file of this one. */
  const work = async (words: string, act: (of: Known<T>, signal: AbortSignal) => Promise<void>): Promise<void> => {
    if (!known || doing) return;
    const { signal } = stop;
    [doing, trouble] = [words, ""];
    draw();
    let wrong = "";
    try {
      await act(known, signal);
    } catch (error) {
      wrong = reason(error);
    }
    if (signal.aborted) return;
    doing = "";
    if (wrong) setText(note, `That did not come: ${wrong}`);
    else draw();
  };

  const write = async ({ columns, record }: PageFile<T>, of: Known<T>, signal: AbortSignal): Promise<void> => {
    const all = await everything(kind, of.stretch, signal, (count) => setText(note, `Fetching all of this time: ${count} so far …`));
    if (signal.aborted) return;
    const name = vessel();
    const text = csv(["vessel", ...columns], all.map((one) => [name, ...record(one)]));
    save(`${name} ${utc(of.stretch.fromUs)} to ${utc(of.stretch.toUs)} ${label.toLowerCase()}.csv`.replaceAll(":", "").replaceAll(" ", "_"), text);
  };

  older.addEventListener("click", () =>
    void work("Fetching older ones …", async (of, signal) => {
      const part = await kind.ask(question(of.stretch, kind.page, of.next), signal);
      if (signal.aborted || !known) return;
      const held = document.activeElement === older;
      const longer = lengthened(of, part, kind);
      // Newer ones may have come meanwhile.
      known = known === of ? longer : refreshed(longer, known, known.stretch, kind);
      changed();
      if (held && !known.next) box.focus();
    }),
  );
  if (typeof file !== "function") take.addEventListener("click", () => void work("Fetching all of this time …", (of, signal) => write(file, of, signal)));
  const show = async (stretch: Stretch, goesOn: boolean, signal: AbortSignal): Promise<void> => {
    const anew = !goesOn || !known;
    if (anew) {
      stop.abort();
      stop = new AbortController();
      meanwhile = within(known?.items ?? meanwhile, stretch);
      [known, trouble, doing] = [undefined, "", "Fetching …"];
      changed();
    }
    try {
      const part = await kind.ask(question(stretch, kind.page, null), signal);
      if (signal.aborted) return;
      known = refreshed(known, part, stretch, kind);
      [trouble, missingUs] = ["", null];
      join(latest, stretch);
    } catch (error) {
      if (signal.aborted) return;
      trouble = `${known ? "Not brought up to date" : "Not known"}: ${reason(error)}`;
    }
    if (anew) doing = "";
    changed();
  };

  return {
    show,
    async follow(stretch, signal) {
      if (!known) return show(stretch, false, signal);
      if (join([], stretch)) changed();
      await catchUp(signal);
    },
    live(some, stretch) {
      latest = [...latest, ...some].slice(-LATEST);
      if (join(some, stretch)) changed();
    },
    missed(sinceUs, stretch) {
      join([], stretch);
      missingUs = Math.min(missingUs ?? sinceUs, sinceUs);
      if (meanwhileUs !== undefined) meanwhileUs = Math.min(meanwhileUs ?? sinceUs, sinceUs);
      void catchUp(stop.signal);
    },
    cursor(us) {
      if (us === cursorUs) return;
      cursorUs = us;
      mark();
    },
    draw,
    known: () => known ?? { items: meanwhile, next: null },
  };
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

function row<T extends Event>(one: T, kind: Kind<T>): HTMLElement {
  const made = make("tr", { "data-us": String(one.time_us), ...kind.marks(one) });
  const tag = kind.tag?.(one);
  kind.cells(one).forEach((text, index) => {
    const inside = index === 0 ? make("button", { type: "button", class: "plain" }, text) : text;
    made.append(make("td", { ...(index === 0 ? { class: "num" } : {}), ...(index === 1 && tag !== undefined ? { "data-tag": tag } : {}) }, inside));
  });
  return made;
}

/** Tells of rows that are pointed to and chosen, by pointer and by keys. */
function listen(body: HTMLElement, box: HTMLElement, at: (us: number | null) => void, pick: (us: number) => void): void {
  const rowOf = (event: globalThis.Event): HTMLElement | null => (event.target instanceof Element ? event.target.closest<HTMLElement>("tr[data-us]") : null);
  const point = (event: globalThis.Event): void => {
    const row = rowOf(event);
    at(row ? Number(row.dataset["us"]) : null);
  };
  body.addEventListener("pointerover", point);
  body.addEventListener("focusin", point);
  box.addEventListener("pointerleave", () => at(null));
  body.addEventListener("focusout", () => at(null));
  body.addEventListener("click", (event) => {
    const row = rowOf(event);
    if (row) pick(Number(row.dataset["us"]));
  });
}
