// The rows of a table of events: those that stay are not touched, for one of them may have the focus, or be read.

import { make, setAttribute } from "./dom";

/** How an event is a row. */
export interface RowKind<T> {
  key(one: T): string;
  cells(one: T): readonly string[];
  /** Further marks of its row. */
  marks(one: T): Readonly<Record<string, string>>;
  /** Of the second cell. */
  tag?(one: T): string;
}

interface Drawn<T> {
  readonly one: T;
  readonly element: HTMLElement;
}

export class EventRows<T extends { readonly time_us: number }> {
  private readonly body = make("tbody");
  readonly box: HTMLElement;
  private shown: readonly T[] = [];
  private rows = new Map<string, Drawn<T>>();
  private cursorUs: number | null = null;

  /** `at` is told of rows that are pointed to, `pick` of those that are chosen, by pointer and by keys. */
  constructor(private readonly kind: RowKind<T>, label: string, names: readonly string[], older: HTMLElement, at: (us: number | null) => void, pick: (us: number) => void) {
    const head = make("tr", {}, ...names.map((name) => make("th", { scope: "col" }, name)));
    this.box = make("div", { class: "wide scroll", tabindex: "0", role: "region", "aria-label": label }, make("table", { class: "compact" }, make("thead", {}, head), this.body), older);
    listen(this.body, this.box, at, pick);
  }

  /** These and no others, the newest first. */
  fill(shown: readonly T[]): void {
    const before = this.shown;
    this.shown = shown;
    if (before.length !== shown.length || shown.some((one, at) => one !== before[at])) this.replace();
    this.mark();
  }

  /** Marks the last row at or before a time; null for none. */
  cursor(us: number | null): void {
    if (us === this.cursorUs) return;
    this.cursorUs = us;
    this.mark();
  }

  private replace(): void {
    const next = new Map(this.shown.map((one) => [this.kind.key(one), this.rowOf(one)]));
    for (const [key, { element }] of this.rows) if (next.get(key)?.element !== element) element.remove();
    let at = this.body.firstElementChild;
    for (const { element } of next.values()) {
      if (element === at) at = at.nextElementSibling;
      else this.body.insertBefore(element, at);
    }
    this.rows = next;
  }

  private rowOf(one: T): Drawn<T> {
    const before = this.rows.get(this.kind.key(one));
    return before?.one === one ? before : { one, element: row(one, this.kind) };
  }

  private mark(): void {
    const us = this.cursorUs;
    // The newest comes first.
    const index = us === null ? -1 : this.shown.findIndex(({ time_us }) => time_us <= us);
    [...this.body.children].forEach((row, number) => setAttribute(row, "aria-current", number === index ? "time" : null));
  }
}

function row<T extends { readonly time_us: number }>(one: T, kind: RowKind<T>): HTMLElement {
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
