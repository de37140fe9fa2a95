// The form of a note: text first, then what it is about. What is wrong is said at its field.

import { useEffect, useRef, useState } from "preact/hooks";
import { type Draft, LETTERS, PHOTO_KINDS, type Wrong, wrongOf } from "../state/notes";

interface Needs {
  readonly draft: Draft;
  /** Addresses and names of vessels that may be written about. */
  readonly vessels: readonly (readonly [string, string])[];
  /** Whether a photo may come with it. */
  readonly withPhoto: boolean;
  readonly label: string;
  /** Puts the ids of two forms on one page apart. */
  readonly id: string;
  /** Sends it; what is wrong, or nothing where it is done. */
  send(draft: Draft, photo: File | undefined): Promise<Wrong | undefined>;
  readonly cancel?: () => void;
  /** Whether the text has the focus at once. */
  readonly focus?: boolean;
}

const PLACE_MS = 20_000;

export function NoteForm({ draft: first, vessels, withPhoto, label, id, send, cancel, focus }: Needs) {
  const [draft, set] = useState(first);
  const [wrong, told] = useState<Wrong | undefined>(undefined);
  const [busy, work] = useState(false);
  const text = useRef<HTMLTextAreaElement>(null);
  const photo = useRef<HTMLInputElement>(null);
  useEffect(() => {
    if (focus) text.current?.focus();
  }, []);
  const change = (part: Partial<Draft>): void => {
    set({ ...draft, ...part });
    told(undefined);
  };
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault();
    if (busy) return;
    let now = wrongOf(draft);
    if (!now) {
      work(true);
      now = await send(draft, photo.current?.files?.[0]);
      work(false);
    }
    told(now);
    if (now) document.getElementById(`${id}-${now.field}`)?.focus();
    else if (!cancel) {
      // The next note is often about the same vessel.
      set({ ...draft, text: "", time: "", lat: "", lon: "" });
      if (photo.current) photo.current.value = "";
      text.current?.focus();
    }
  };
  const here = (): void => {
    work(true);
    navigator.geolocation.getCurrentPosition(
      ({ coords }) => {
        work(false);
        change({ lat: coords.latitude.toFixed(6), lon: coords.longitude.toFixed(6) });
      },
      () => {
        work(false);
        told({ field: "lat_deg", text: "Your device did not give a position. Type one, or leave it empty." });
      },
      { enableHighAccuracy: true, timeout: PLACE_MS },
    );
  };
  const at = (field: string): string => (wrong?.field === field ? wrong.text : "");
  const marks = (field: string) => ({ id: `${id}-${field}`, "aria-invalid": at(field) !== "", "aria-describedby": `${id}-${field}-wrong` });
  const Told = ({ field }: { readonly field: string }) => <p id={`${id}-${field}-wrong`} class="wrong" role="alert">{at(field)}</p>;
  return (
    <form class="note-form" aria-label={label} noValidate onSubmit={(event) => void submit(event)}>
      <div class="field">
        <label for={`${id}-text`}>Text</label>
        <textarea ref={text} {...marks("text")} rows={3} maxLength={LETTERS * 2} value={draft.text} onInput={(event) => change({ text: event.currentTarget.value })} />
        {Told({ field: "text" })}
      </div>
      <div class="filters">
        <div class="field">
          <label for={`${id}-vessel`}>About vessel</label>
          <select {...marks("vessel")} value={draft.vessel} onChange={(event) => change({ vessel: event.currentTarget.value })}>
            <option value="">No vessel</option>
            {vessels.map(([address, name]) => <option key={address} value={address}>{name}</option>)}
          </select>
          {Told({ field: "vessel" })}
        </div>
        <div class="field">
          <label for={`${id}-time_us`}>Time (UTC), empty for now</label>
          <input {...marks("time_us")} type="datetime-local" step="1" value={draft.time} onInput={(event) => change({ time: event.currentTarget.value })} />
          {Told({ field: "time_us" })}
        </div>
        <div class="field">
          <label for={`${id}-lat_deg`}>Latitude, °</label>
          <input {...marks("lat_deg")} inputMode="text" size={12} autocomplete="off" value={draft.lat} onInput={(event) => change({ lat: event.currentTarget.value })} />
          {Told({ field: "lat_deg" })}
        </div>
        <div class="field">
          <label for={`${id}-lon_deg`}>Longitude, °</label>
          <input {...marks("lon_deg")} inputMode="text" size={12} autocomplete="off" value={draft.lon} onInput={(event) => change({ lon: event.currentTarget.value })} />
          {Told({ field: "lon_deg" })}
        </div>
        {"geolocation" in navigator && <button type="button" disabled={busy} onClick={here}>My position</button>}
        {withPhoto && (
          <div class="field">
            <label for={`${id}-photo`}>Photo (JPEG, PNG or WebP)</label>
            <input ref={photo} {...marks("photo")} type="file" accept={PHOTO_KINDS} />
            {Told({ field: "photo" })}
          </div>
        )}
      </div>
      <p class="row">
        <button class="main" aria-disabled={busy}>{cancel ? "Save" : "Write"}</button>
        {cancel && <button type="button" onClick={cancel}>Cancel</button>}
        <span role="status">{busy ? "Sending …" : ""}</span>
        {wrong && !document.getElementById(`${id}-${wrong.field}`) && <span class="bad-text" role="alert">{wrong.text}</span>}
      </p>
    </form>
  );
}
