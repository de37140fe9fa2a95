// The form of a note: text first, then what it is about. What is wrong is said at its field.

import type { ComponentChildren } from "preact";
import { useRef, useState } from "preact/hooks";
import { type Draft, LETTERS, PHOTO_KINDS, type Wrong, wrongOf } from "../state/notes";
import { t } from "../words/words";
import { Field, FormEnd, type Marks, useFirstFocus, useSent } from "./sentform";
import { WhenField } from "./when";

interface Needs {
  readonly draft: Draft;
  /** Addresses and names of vessels that may be written about. */
  readonly vessels: readonly (readonly [string, string])[];
  /** Whether a photo may come with it. */
  readonly withPhoto: boolean;
  readonly label: string;
  /** Puts the ids of two forms on one page apart. */
  readonly id: string;
  /** Sends it; what is wrong, or nothing where it is done. `waits` is told where nobody answered and it is tried again. */
  send(draft: Draft, photo: File | undefined, waits: (tries: number) => void): Promise<Wrong | undefined>;
  readonly cancel?: () => void;
  /** Whether the text has the focus at once. */
  readonly focus?: boolean;
}

const PLACE_MS = 20_000;

export function NoteForm(needs: Needs) {
  const { vessels, withPhoto, label, id, cancel, focus } = needs;
  const form = useNote(needs);
  const { draft, locating, text, photo, change } = form;
  useFirstFocus(() => (focus ? text.current : undefined));
  const field = (name: string, title: string, input: (marks: Marks) => ComponentChildren) => <Field key={name} id={`${id}-${name}`} label={title} wrong={form.at(name)} input={input} />;
  return (
    <form class="note-form" aria-label={label} noValidate onSubmit={(event) => void form.submit(event)}>
      {field("text", t("Text"), (marks) => <textarea ref={text} {...marks} rows={3} maxLength={LETTERS * 2} value={draft.text} onInput={(event) => change({ text: event.currentTarget.value })} />)}
      <div class="filters">
        {field("vessel", t("About vessel"), (marks) => (
          <select {...marks} value={draft.vessel} onChange={(event) => change({ vessel: event.currentTarget.value })}>
            <option value="">{t("No vessel")}</option>
            {vessels.map(([address, name]) => <option key={address} value={address}>{name}</option>)}
          </select>
        ))}
        {field("time_us", t("Time (UTC), empty for now"), (marks) => <WhenField marks={marks} value={draft.time} changed={(time) => change({ time })} />)}
        {withPhoto && field("photo", t("Photo (JPEG, PNG or WebP)"), (marks) => <input ref={photo} {...marks} type="file" accept={PHOTO_KINDS} />)}
      </div>
      <div class="filters">
        {field("lat_deg", t("Latitude, °"), (marks) => <input {...marks} inputMode="text" size={12} autocomplete="off" value={draft.lat} onInput={(event) => change({ lat: event.currentTarget.value })} />)}
        {field("lon_deg", t("Longitude, °"), (marks) => <input {...marks} inputMode="text" size={12} autocomplete="off" value={draft.lon} onInput={(event) => change({ lon: event.currentTarget.value })} />)}
        {"geolocation" in navigator && <button type="button" disabled={locating} onClick={form.here}>{locating ? t("Asking your device …") : t("My position")}</button>}
      </div>
      <FormEnd of={form.end} save={cancel ? t("Save") : t("Write")} cancel={cancel} />
    </form>
  );
}

/** The draft of a note, and what becomes of it. */
function useNote({ draft: first, id, send, cancel }: Needs) {
  const text = useRef<HTMLTextAreaElement>(null);
  const photo = useRef<HTMLInputElement>(null);
  const picture = (): File | undefined => photo.current?.files?.[0];
  let underWay: File | undefined;
  const form = useSent<Draft>({
    id,
    first,
    wrongOf,
    send(draft, waits) {
      underWay = picture();
      return send(draft, underWay, waits);
    },
    sent(draft) {
      if (cancel) return;
      // The next note is often about the same vessel. What was typed while this one was on its way stays.
      form.set((now) => (now === draft ? { ...draft, text: "", time: "", lat: "", lon: "" } : now));
      if (photo.current && picture() === underWay) photo.current.value = "";
      text.current?.focus();
    },
  });
  const [locating, locate] = useState(false);
  const here = (): void => {
    locate(true);
    const found = ({ coords }: GeolocationPosition): void => {
      locate(false);
      form.change({ lat: coords.latitude.toFixed(6), lon: coords.longitude.toFixed(6) });
    };
    const none = (): void => {
      locate(false);
      form.told({ field: "lat_deg", text: t("Your device did not give a position. Type one, or leave it empty.") });
    };
    navigator.geolocation.getCurrentPosition(found, none, { enableHighAccuracy: true, timeout: PLACE_MS });
  };
  return { ...form, locating, text, photo, here };
}
