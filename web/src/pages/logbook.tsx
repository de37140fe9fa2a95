// The log book that people keep: the form of a note, a filter, and the notes by day.

import { computed, effect, type Signal, signal } from "@preact/signals";
import { render } from "preact";
import { getJson } from "../api/http";
import { postUntilAnswered } from "../api/retry";
import type { LogNote, LogNotes } from "../api/types.gen";
import { resource } from "../api/resource";
import { NoteForm } from "../components/noteform";
import { NoteList } from "../components/notelist";
import { Spans, TimeSpan } from "../components/timespan";
import { addressOf, askOf, type Draft, draftFrom, EMPTY_DRAFT, type Filter, filterFrom, questionOf, withNewest, type Wrong } from "../state/notes";
import { Keys } from "../state/sending";
import { spanWrong } from "../state/takeout";
import { newKey } from "../state/window";
import { createChrome } from "../ui/chrome";
import { hexAddress } from "../ui/format";
import { sendPhoto, wrongFrom } from "../ui/photo";
import { t, tn } from "../words/words";

/** After the last change of the filter the notes are asked for, ms. */
const REST_MS = 350;
const PATIENCE_MS = 15_000;
/** For so long a note that nobody answers is sent again by itself, ms. */
const SENT_WITHIN_MS = 120_000;
/** Notes by others come after so long at most, ms. */
const AGAIN_MS = 20_000;

/** What the page knows: the filter, its notes, and what is on its way. */
class Book {
  readonly vessel: Signal<string>;
  readonly from: Signal<string>;
  readonly to: Signal<string>;
  readonly text: Signal<string>;
  readonly withdrawn: Signal<boolean>;
  readonly filter = computed<Filter>(() => ({ vessel: this.vessel.value, from: this.from.value, to: this.to.value, text: this.text.value, withdrawn: this.withdrawn.value }));
  readonly wrong = computed(() => spanWrong(this.from.value, this.to.value)?.text ?? "");
  readonly notes = signal<readonly LogNote[]>([]);
  readonly next = signal<string | null>(null);
  readonly page = resource<LogNotes>();
  /** A photo that did not get through; its note did. */
  readonly unsent = signal<{ readonly note: LogNote; readonly photo: File; readonly why: string } | undefined>(undefined);
  private readonly keys = new Keys<Draft>(newKey);

  constructor(first: Filter) {
    [this.vessel, this.from, this.to] = [signal(first.vessel), signal(first.from), signal(first.to)];
    [this.text, this.withdrawn] = [signal(first.text), signal(first.withdrawn)];
  }

  readonly show = async (): Promise<void> => {
    if (this.wrong.value) return;
    const found = await this.page.ask(`/api/v1/logbook?${questionOf(this.filter.value)}`);
    if (found) [this.notes.value, this.next.value] = [found.notes, found.next];
  };

  readonly older = async (): Promise<void> => {
    const found = await this.page.ask(`/api/v1/logbook?${questionOf(this.filter.value)}&before=${this.next.value}`);
    if (found) [this.notes.value, this.next.value] = [[...this.notes.value, ...found.notes], found.next];
  };

  /** What others wrote comes by itself; who asks for something meanwhile goes first. */
  async again(): Promise<void> {
    const [of, { busy }] = [this.filter.value, this.page];
    if (document.hidden || busy.value || this.wrong.value) return;
    const found = await getJson<LogNotes>(`/api/v1/logbook?${questionOf(of)}`, AbortSignal.timeout(PATIENCE_MS)).catch(() => undefined);
    if (!found || this.filter.value !== of || busy.value) return;
    const all = withNewest(this.notes.value, found);
    if (all.length === found.notes.length) this.next.value = found.next;
    this.notes.value = all;
  }

  readonly write = async (written: Draft, photo: File | undefined, waits: (tries: number) => void): Promise<Wrong | undefined> => {
    try {
      const sent = this.keys.of(written);
      const path = (): string => `/api/v1/logbook?${new URLSearchParams({ key: sent.key, waited_ms: String(this.keys.waitedMs(sent)) })}`;
      const note = await postUntilAnswered<LogNote>(path, PATIENCE_MS, SENT_WITHIN_MS, askOf(written), waits);
      this.keys.answered();
      if (photo) await this.addPhoto(note, photo);
      void this.show();
      return undefined;
    } catch (error) {
      return wrongFrom(error);
    }
  };

  async addPhoto(note: LogNote, photo: File): Promise<void> {
    try {
      await sendPhoto(note, photo);
      this.unsent.value = undefined;
    } catch (error) {
      this.unsent.value = { note, photo, why: wrongFrom(error).text };
    }
  }

  readonly changed = (note: LogNote): void => {
    this.notes.value = this.notes.value.map((one) => (one.id === note.id ? note : one));
    if (note.photo && this.unsent.value?.note.id === note.id) this.unsent.value = undefined;
  };

  /** The page's address has the filter; the notes are asked for when it has rested. */
  follow(): void {
    let timer = 0;
    effect(() => {
      const address = addressOf(this.filter.value);
      window.clearTimeout(timer);
      timer = window.setTimeout(() => {
        history.replaceState(null, "", `/logbook${address}`);
        void this.show();
      }, REST_MS);
    });
  }
}

/** Addresses and names of vessels. */
type Named = readonly (readonly [string, string])[];

function Filters({ book, names }: { readonly book: Book; readonly names: Named }) {
  const { vessel, from, to, text, withdrawn, wrong } = book;
  return (
    <form class="filters" aria-label={t("Filter")} onSubmit={(event) => { event.preventDefault(); void book.show(); }}>
      <div class="field">
        <label for="of-vessel">{t("Vessel")}</label>
        <select id="of-vessel" value={vessel.value} onChange={(event) => (vessel.value = event.currentTarget.value)}>
          <option value="">{t("All vessels, and notes about no vessel")}</option>
          {names.map(([address, name]) => <option key={address} value={address}>{name}</option>)}
        </select>
      </div>
      <TimeSpan from={from} to={to} toWrong={wrong.value} />
      <div class="field">
        <label for="of-text">{t("Text contains")}</label>
        <input id="of-text" type="search" value={text.value} autocomplete="off" maxLength={200} onInput={(event) => (text.value = event.currentTarget.value)} />
      </div>
      <label class="inline"><input type="checkbox" checked={withdrawn.value} onChange={(event) => (withdrawn.value = event.currentTarget.checked)} />{t("Show withdrawn")}</label>
      <Spans from={from} to={to} />
    </form>
  );
}

function Nothing({ book: { page, filter }, writes }: { readonly book: Book; readonly writes: boolean }) {
  if (page.busy.value || page.trouble.value || !page.value.value) return null;
  if (addressOf(filter.value)) return <p>{t("No matching notes. Choose a longer time, or clear the filter.")}</p>;
  return <p>{writes ? t("The log book is empty. Write the first note above: what was done and seen, and when.") : t("The log book is empty. Operators write notes into it.")}</p>;
}

function Unsent({ book }: { readonly book: Book }) {
  const unsent = book.unsent.value;
  if (!unsent) return null;
  const again = (): void => void book.addPhoto(unsent.note, unsent.photo).then(book.show);
  return <p class="note warn" role="alert">{t("The note is kept, its photo is not:")}{" "}{unsent.why} <button type="button" onClick={again}>{t("Send the photo again")}</button></p>;
}

function countText(count: number, more: boolean): string {
  if (!count) return "";
  return more ? tn(count, "{n} newest note.", "{n} newest notes.") : tn(count, "{n} note.", "{n} notes.");
}

/** The notes of the filter; `may`: whether the person may take them away. */
function Notes({ book, names, writable, writes, may }: { readonly book: Book; readonly names: Named; readonly writable: Named; readonly writes: boolean; readonly may: boolean }) {
  const { page, notes, next, filter } = book;
  return (
    <section>
      <h2>{t("Notes")}</h2>
      <Filters book={book} names={names} />
      {page.trouble.value && <p class="bad-text" role="alert">{page.trouble.value} <button type="button" onClick={() => void book.show()}>{t("Try again")}</button></p>}
      <p role="status">{page.busy.value ? t("Fetching …") : countText(notes.value.length, next.value !== null)}</p>
      {notes.value.length === 0 && <Nothing book={book} writes={writes} />}
      {may && notes.value.length > 0 && <p><a class="button" href={`/api/v1/logbook.csv?${questionOf(filter.value)}`} download>{t("Download CSV of all notes of this filter")}</a></p>}
      <NoteList notes={notes.value} vessels={writable} changed={book.changed} again={() => void book.show()} />
      {next.value && <button type="button" onClick={() => void book.older()}>{t("Older notes")}</button>}
    </section>
  );
}

export function startLogbook(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["names"] ?? "{}") as Record<string, string>;
  const query = new URLSearchParams(location.search);
  const [writes, may, begins] = [root.dataset["writes"] ?? "", root.dataset["researcher"] !== undefined, query.has("write")];
  const draft = begins ? draftFrom(query) : EMPTY_DRAFT;
  const book = new Book(filterFrom(begins ? new URLSearchParams() : query));
  const all = Object.entries(names);
  const writable = all.filter(([address]) => writes === "all" || writes.split(",").includes(address));
  if (draft.vessel && !names[draft.vessel]) writable.push([draft.vessel, hexAddress(Number(draft.vessel))]);
  window.setInterval(() => void book.again(), AGAIN_MS);
  book.follow();
  const Page = () => (
    <>
      {writes && (
        <section class="write">
          <h2>{t("Write a note")}</h2>
          <NoteForm draft={draft} vessels={writable} withPhoto label={t("Write a note")} id="new" send={book.write} focus={begins} />
          <Unsent book={book} />
        </section>
      )}
      <Notes book={book} names={all} writable={writable} writes={writes !== ""} may={may} />
    </>
  );
  root.replaceChildren();
  render(<Page />, root);
  createChrome({ messages: ["VehicleState"], events: false, every_ms: 500 }, {});
}
