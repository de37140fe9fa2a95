// A table of events of a stretch of time: the newest first, older ones by a button, all of them as CSV.

import { reason } from "../api/http";
import { type Event, type Known, lengthened, type Part, question, refreshed, type Stretch, within } from "../state/newest";
import { csv, save } from "./csv";
import { make, setAttribute, setText } from "./dom";
import { utc } from "./format";

/** Events that are asked for at once to be written into a file, which is the most. */
const FILE_PAGE = 10_000;

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
  /** Marks the last row at or before a time; null for none. */
  cursor(us: number | null): void;
  /** Draws anew, after what is wanted of the events has changed. */
  draw(): void;
  /** Those that are in hand, and whether there are older ones. */
  readonly known: () => Part<T>;
}

/** What a table is about. */
export interface Kind<T extends Event> {
  /** As in "the newest 2 of 3 …", and in the names of files. */
  readonly label: string;
  /** Heads of the columns. */
  readonly names: readonly string[];
  /** The same in a file, with units; the vessel comes before them. */
  readonly columns: readonly string[];
  /** How many are shown at first, and more with each asking. */
  readonly page: number;
  ask(query: string, signal: AbortSignal): Promise<Part<T>>;
  /** Tells events apart. */
  key(one: T): string;
  cells(one: T): readonly string[];
  record(one: T): readonly (string | number | null)[];
  /** Further marks of its row. */
  marks(one: T): Readonly<Record<string, string>>;
  /** Of the second cell. */
  tag?(one: T): string;
  /** Whether somebody wants to see it. */
  wanted(one: T): boolean;
  /** Whether those that are wanted are all in hand, so that a file needs no others. */
  chosen(): boolean;
  /** What to say of those that are shown; `cut` tells which part of the time they are of. */
  note(shown: number, all: number, cut: string): string;
  /** Called whenever what is in hand has changed. */
  changed(known: Part<T>): void;
}

export function eventTable<T extends Event>(root: HTMLElement, kind: Kind<T>, { at, pick, vessel, may }: EventHandlers, ...extra: readonly HTMLElement[]): EventTable<T> {
  const { label, names } = kind;
  const note = make("p", { class: "dim", role: "status" });
  const take = make("button", { type: "button", hidden: "", "aria-label": `Download CSV of ${label.toLowerCase()} as shown, of all of this time` }, "CSV");
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
  let drawn = "";
  let cursorUs: number | null = null;

  const mark = (): void => {
    // The newest comes first.
    const index = cursorUs === null ? -1 : shown.findIndex(({ time_us }) => time_us <= (cursorUs ?? 0));
    [...body.children].forEach((row, number) => setAttribute(row, "aria-current", number === index ? "time" : null));
  };
  /** Rows that stay are not touched: one of them may have the focus, or be read. */
  let rows = new Map<string, HTMLElement>();
  const fill = (wanted: readonly T[]): void => {
    const next = new Map(wanted.map((one) => [kind.key(one), rows.get(kind.key(one)) ?? row(one, kind)]));
    for (const [key, gone] of rows) if (!next.has(key)) gone.remove();
    let at = body.firstElementChild;
    for (const one of next.values()) {
      if (one === at) at = at.nextElementSibling;
      else body.insertBefore(one, at);
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
    const now = shown.map(kind.key).join("\n");
    if (now !== drawn) {
      drawn = now;
      fill(shown);
    }
    mark();
  };
  const changed = (): void => {
    draw();
    kind.changed(known ?? { items: meanwhile, next: null });
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

  older.addEventListener("click", () =>
    void work("Fetching older ones …", async (of, signal) => {
      const part = await kind.ask(question(of.stretch, kind.page, of.next), signal);
      if (signal.aborted || !known) return;
      const held = document.activeElement === older;
      const longer = lengthened(of, part);
      // Newer ones may have come meanwhile.
      known = known === of ? longer : refreshed(longer, known, known.stretch, kind.key);
      changed();
      if (held && !known.next) box.focus();
    }),
  );
  take.addEventListener("click", () =>
    void work("Fetching all of this time …", async (of, signal) => {
      const all = kind.chosen() ? shown : await whole(kind, of.stretch, signal, (count) => setText(note, `Fetching all of this time: ${count} so far …`));
      if (signal.aborted) return;
      const name = vessel();
      const text = csv(["vessel", ...kind.columns], all.map((one) => [name, ...kind.record(one)]));
      save(`${name} ${utc(of.stretch.fromUs)} to ${utc(of.stretch.toUs)} ${label.toLowerCase()}.csv`.replaceAll(":", "").replaceAll(" ", "_"), text);
    }),
  );

  return {
    async show(stretch, goesOn, signal) {
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
        known = refreshed(known, part, stretch, kind.key);
        trouble = "";
      } catch (error) {
        if (signal.aborted) return;
        trouble = `${known ? "Not brought up to date" : "Not known"}: ${reason(error)}`;
      }
      if (anew) doing = "";
      changed();
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
async function whole<T extends Event>(kind: Kind<T>, stretch: Stretch, signal: AbortSignal, told: (count: number) => void): Promise<T[]> {
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
