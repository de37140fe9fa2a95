// The log book that people keep: the form of a note, a filter, and the notes by day.

import { computed, effect, signal } from "@preact/signals";
import { render } from "preact";
import { getJson, postJson } from "../api/http";
import type { LogNote, LogNotes } from "../api/types.gen";
import { resource } from "../api/resource";
import { NoteForm } from "../components/noteform";
import { NoteList } from "../components/notelist";
import { Spans, TimeSpan } from "../components/timespan";
import { addressOf, askOf, type Draft, draftFrom, EMPTY_DRAFT, type Filter, filterFrom, questionOf, withNewest, type Wrong } from "../state/notes";
import { pickedUs } from "../state/takeout";
import { createChrome } from "../ui/chrome";
import { hexAddress } from "../ui/format";
import { sendPhoto, wrongFrom } from "../ui/photo";

/** After the last change of the filter the notes are asked for, ms. */
const REST_MS = 350;
const PATIENCE_MS = 15_000;
/** Notes by others come after so long at most, ms. */
const AGAIN_MS = 20_000;

export function startLogbook(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["names"] ?? "{}") as Record<string, string>;
  const query = new URLSearchParams(location.search);
  const [writes, may] = [root.dataset["writes"] ?? "", root.dataset["researcher"] !== undefined];
  const draft = query.has("write") ? draftFrom(query) : EMPTY_DRAFT;
  const first = query.has("write") ? filterFrom(new URLSearchParams()) : filterFrom(query);
  const [vessel, from, to] = [signal(first.vessel), signal(first.from), signal(first.to)];
  const [text, withdrawn] = [signal(first.text), signal(first.withdrawn)];
  const filter = computed<Filter>(() => ({ vessel: vessel.value, from: from.value, to: to.value, text: text.value, withdrawn: withdrawn.value }));
  const wrong = computed(() => (from.value && to.value && pickedUs(to.value) <= pickedUs(from.value) ? "The end is not after the beginning." : ""));
  const notes = signal<readonly LogNote[]>([]);
  const next = signal<string | null>(null);
  const page = resource<LogNotes>();
  /** A photo that did not get through; its note did. */
  const unsent = signal<{ readonly note: LogNote; readonly photo: File; readonly why: string } | undefined>(undefined);

  const show = async (): Promise<void> => {
    if (wrong.value) return;
    const found = await page.ask(`/api/v1/logbook?${questionOf(filter.value)}`);
    if (found) [notes.value, next.value] = [found.notes, found.next];
  };
  /** What others wrote comes by itself; who asks for something meanwhile goes first. */
  const again = async (): Promise<void> => {
    const of = filter.value;
    if (document.hidden || page.busy.value || wrong.value) return;
    const found = await getJson<LogNotes>(`/api/v1/logbook?${questionOf(of)}`, AbortSignal.timeout(PATIENCE_MS)).catch(() => undefined);
    if (!found || filter.value !== of || page.busy.value) return;
    const all = withNewest(notes.value, found);
    if (all.length === found.notes.length) next.value = found.next;
    notes.value = all;
  };
  window.setInterval(() => void again(), AGAIN_MS);
  const older = async (): Promise<void> => {
    const found = await page.ask(`/api/v1/logbook?${questionOf(filter.value)}&before=${next.value}`);
    if (found) [notes.value, next.value] = [[...notes.value, ...found.notes], found.next];
  };
  const addPhoto = async (note: LogNote, photo: File): Promise<void> => {
    try {
      await sendPhoto(note, photo);
      unsent.value = undefined;
    } catch (error) {
      unsent.value = { note, photo, why: wrongFrom(error).text };
    }
  };
  const write = async (written: Draft, photo: File | undefined): Promise<Wrong | undefined> => {
    try {
      const note = await postJson<LogNote>("/api/v1/logbook", PATIENCE_MS, askOf(written));
      if (photo) await addPhoto(note, photo);
      void show();
      return undefined;
    } catch (error) {
      return wrongFrom(error);
    }
  };
  const changed = (note: LogNote): void => {
    notes.value = notes.value.map((one) => (one.id === note.id ? note : one));
    if (note.photo && unsent.value?.note.id === note.id) unsent.value = undefined;
  };
  let timer = 0;
  effect(() => {
    const address = addressOf(filter.value);
    window.clearTimeout(timer);
    timer = window.setTimeout(() => {
      history.replaceState(null, "", `/logbook${address}`);
      void show();
    }, REST_MS);
  });

  const writable = Object.entries(names).filter(([address]) => writes === "all" || writes.split(",").includes(address));
  if (draft.vessel && !names[draft.vessel]) writable.push([draft.vessel, hexAddress(Number(draft.vessel))]);
  const Filters = () => (
    <form class="filters" aria-label="Filter" onSubmit={(event) => { event.preventDefault(); void show(); }}>
      <div class="field">
        <label for="of-vessel">Vessel</label>
        <select id="of-vessel" value={vessel.value} onChange={(event) => (vessel.value = event.currentTarget.value)}>
          <option value="">All, and notes on none</option>
          {Object.entries(names).map(([address, name]) => <option key={address} value={address}>{name}</option>)}
        </select>
      </div>
      <TimeSpan from={from} to={to} toWrong={wrong.value} />
      <div class="field">
        <label for="of-text">Words in the text</label>
        <input id="of-text" type="search" value={text.value} autocomplete="off" maxLength={200} onInput={(event) => (text.value = event.currentTarget.value)} />
      </div>
      <label class="inline"><input type="checkbox" checked={withdrawn.value} onChange={(event) => (withdrawn.value = event.currentTarget.checked)} />Withdrawn too</label>
      <Spans from={from} to={to} />
    </form>
  );
  const Nothing = () => {
    if (page.busy.value || page.trouble.value || !page.value.value) return null;
    if (addressOf(filter.value)) return <p>No note is like this. Choose a longer time, or clear the filter.</p>;
    return <p>{writes ? "The log book is empty. Write the first note above: what was done and seen, and when." : "The log book is empty. Operators write notes into it."}</p>;
  };
  const Page = () => (
    <>
      {writes && (
        <section class="write">
          <h2>Write a note</h2>
          <NoteForm draft={draft} vessels={writable} withPhoto label="Write a note" id="new" send={write} focus={query.has("write")} />
          {unsent.value && <p class="note warn" role="alert">The note is kept, its photo is not: {unsent.value.why} <button type="button" onClick={() => unsent.value && void addPhoto(unsent.value.note, unsent.value.photo).then(show)}>Send the photo again</button></p>}
        </section>
      )}
      <section>
        <h2>Notes</h2>
        <Filters />
        {page.trouble.value && <p class="bad-text" role="alert">{page.trouble.value} <button type="button" onClick={() => void show()}>Try again</button></p>}
        <p role="status">{page.busy.value ? "Fetching …" : notes.value.length ? `${notes.value.length}${next.value ? " newest" : ""} ${notes.value.length === 1 ? "note" : "notes"}.` : ""}</p>
        {notes.value.length === 0 && <Nothing />}
        {may && notes.value.length > 0 && <p><a class="button" href={`/api/v1/logbook.csv?${questionOf(filter.value)}`} download>Download CSV of all notes of this filter</a></p>}
        <NoteList notes={notes.value} vessels={writable} changed={changed} again={() => void show()} />
        {next.value && <button type="button" onClick={() => void older()}>Older notes</button>}
      </section>
    </>
  );
  root.replaceChildren();
  render(<Page />, root);
  createChrome({ messages: ["VehicleState"], events: false, every_ms: 500 }, {});
}
