// Notes of the log book by day, the newest first, each with what may be done to it.

import { useState } from "preact/hooks";
import { deleteAt, getJson, patchJson, reason } from "../api/http";
import type { LogNote, LogNoteChange, LogNoteRevision } from "../api/types.gen";
import { byDay, correctionOf, type Draft, draftOf, isSame, type Wrong } from "../state/notes";
import { hexAddress, position, utc } from "../ui/format";
import { sendPhoto, wrongFrom } from "../ui/photo";
import { t } from "../words/words";
import { NoteForm } from "./noteform";

const PATIENCE_MS = 15_000;

interface Needs {
  readonly notes: readonly LogNote[];
  readonly vessels: readonly (readonly [string, string])[];
  /** A note is another now. */
  changed(note: LogNote): void;
  /** Something was withdrawn: what is shown is asked for again. */
  again(): void;
}

export function NoteList({ notes, ...rest }: Needs) {
  return (
    <>
      {byDay(notes).map(([day, some]) => (
        <section key={day} class="day" aria-label={day}>
          <h3>{day}</h3>
          <ol class="notes">{some.map((note) => <Note key={note.id} note={note} {...rest} />)}</ol>
        </section>
      ))}
    </>
  );
}

export function placeOf({ lat_deg, lon_deg }: Pick<LogNote, "lat_deg" | "lon_deg">): string {
  return lat_deg === null || lon_deg === null ? "" : position({ lat_deg, lon_deg });
}

function Note({ note, vessels, changed, again }: Omit<Needs, "notes"> & { readonly note: LogNote }) {
  const [doing, act] = useState<"" | "correct" | "withdraw">("");
  const [trouble, tell] = useState("");
  const vessel = note.vessel === null ? "" : (note.vessel_name ?? hexAddress(note.vessel));
  const place = placeOf(note);
  const label = t("the note of {time}", { time: utc(note.time_us) });
  const correct = async (draft: Draft, photo: File | undefined): Promise<Wrong | undefined> => {
    try {
      // Whoever only adds a photo corrects nothing.
      if (!isSame(draft, draftOf(note))) {
        const change: LogNoteChange = { revision: note.revision, note: correctionOf(note, draft) };
        changed(await patchJson<LogNote>(`/api/v1/logbook/${note.id}`, change, PATIENCE_MS));
      }
      if (photo) changed(await sendPhoto(note, photo));
      act("");
      return undefined;
    } catch (error) {
      return wrongFrom(error);
    }
  };
  const withdraw = async (): Promise<void> => {
    try {
      await deleteAt(`/api/v1/logbook/${note.id}`, PATIENCE_MS);
      again();
    } catch (error) {
      tell(reason(error));
    }
  };
  return (
    <li class="note-entry" data-withdrawn={note.withdrawn ? "" : undefined}>
      <p class="head">
        <span class="num">{utc(note.time_us, false)}</span>
        {vessel && <strong>{vessel}</strong>}
        <span>{note.by}</span>
        {place && <span class="num dim">{place}</span>}
        {vessel && <a href={watch(note)}>{t("Watch")}</a>}
      </p>
      {doing === "correct" ? (
        <NoteForm draft={draftOf(note)} vessels={vessels} withPhoto={note.photo === null} label={t("Correct {label}", { label })} id={`note-${note.id}`} send={correct} cancel={() => act("")} focus />
      ) : (
        <p class="said">{note.text}</p>
      )}
      {note.photo && <a class="photo-link" href={`/api/v1/logbook/${note.id}/photo`} target="_blank" rel="noopener"><img class="photo" loading="lazy" src={`/api/v1/logbook/${note.id}/photo`} alt={t("Photo of {label}; opens whole in a new tab", { label })} /></a>}
      {note.withdrawn && <p class="dim">{t("Withdrawn by {by}, {time}", { by: note.withdrawn.by, time: utc(note.withdrawn.time_us) })}</p>}
      {note.corrected && <Earlier note={note} />}
      {note.may_change && doing === "" && (
        <p class="row">
          <button type="button" aria-label={t("Correct {label}", { label })} onClick={() => act("correct")}>{t("Correct")}</button>
          <button type="button" aria-label={t("Withdraw {label} …", { label })} onClick={() => act("withdraw")}>{t("Withdraw …")}</button>
        </p>
      )}
      {doing === "withdraw" && (
        <p class="row" role="group" aria-label={t("Withdraw {label}", { label })}>
          <span>{t("It is no longer shown, but kept: \"Show withdrawn\" shows it.")}</span>
          <button type="button" class="main" ref={(node) => node?.focus()} onClick={() => void withdraw()}>{t("Withdraw")}</button>
          <button type="button" onClick={() => act("")}>{t("Keep")}</button>
        </p>
      )}
      {trouble && <p class="bad-text" role="alert">{trouble}</p>}
    </li>
  );
}

/** What a note said before, when somebody wants to see it. */
function Earlier({ note }: { readonly note: LogNote }) {
  const [all, show] = useState<readonly LogNoteRevision[] | undefined>(undefined);
  const [trouble, tell] = useState("");
  if (!note.corrected) return null;
  const ask = async (open: boolean): Promise<void> => {
    if (!open) return;
    try {
      show(await getJson<LogNoteRevision[]>(`/api/v1/logbook/${note.id}/earlier`));
    } catch (error) {
      tell(reason(error));
    }
  };
  return (
    <details class="earlier" key={note.revision} onToggle={(event) => void ask(event.currentTarget.open)}>
      <summary>{t("Corrected by {by}, {time}", { by: note.corrected.by, time: utc(note.corrected.time_us) })}</summary>
      {trouble && <p class="bad-text" role="alert">{trouble}</p>}
      {all?.map((one) => <p key={one.revision} class="said dim">{t("Before, by {by}, about {time}", { by: one.written.by, time: utc(one.time_us) })}{placeOf(one) && `, ${placeOf(one)}`}:<br />{one.text}</p>)}
    </details>
  );
}

/** The vessel's page around the time of the note. */
function watch({ vessel, time_us }: LogNote): string {
  return `/vessels/${vessel}?tab=${encodeURIComponent("Log book")}&from=${Math.max(0, time_us - 300_000_000)}&to=${time_us + 300_000_000}`;
}
