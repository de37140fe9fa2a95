// The form of a mission. What is wrong is said at its field.

import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import { type MissionDraft, missionWrong } from "../state/missions";
import type { Wrong } from "../state/notes";
import { t } from "../words/words";
import { Field, FormEnd, type Marks, useFirstFocus, useSent } from "./sentform";
import { WhenField } from "./when";

interface Needs {
  readonly draft: MissionDraft;
  /** Vessels that may be chosen: addresses and names. */
  readonly vessels: readonly (readonly [number, string])[];
  readonly label: string;
  /** Sends it; what is wrong, or nothing where it is done. `waits` is told where nobody answered and it is tried again. */
  send(draft: MissionDraft, waits: (tries: number) => void): Promise<Wrong | undefined>;
  cancel(): void;
}

export function MissionForm({ draft: first, vessels, label, send, cancel }: Needs) {
  const form = useSent<MissionDraft>({ id: "mission", first, wrongOf: missionWrong, send });
  const { draft, change } = form;
  const name = useRef<HTMLInputElement>(null);
  useFirstFocus(() => name.current);
  const field = (name: string, title: string, input: (marks: Marks) => ComponentChildren) => <Field key={name} id={`mission-${name}`} label={title} wrong={form.at(name)} input={input} />;
  return (
    <form class="note-form" aria-label={label} noValidate onSubmit={(event) => void form.submit(event)}>
      <div class="filters">
        {field("name", t("Name"), (marks) => <input ref={name} {...marks} maxLength={120} autocomplete="off" value={draft.name} onInput={(event) => change({ name: event.currentTarget.value })} />)}
        {field("from_us", t("From (UTC)"), (marks) => <WhenField marks={marks} value={draft.from} changed={(from) => change({ from })} />)}
        {field("to_us", t("To (UTC), empty while it goes on"), (marks) => <WhenField marks={marks} value={draft.to} changed={(to) => change({ to })} />)}
        {field("people", t("People"), (marks) => <input {...marks} maxLength={500} autocomplete="off" value={draft.people} onInput={(event) => change({ people: event.currentTarget.value })} />)}
      </div>
      <VesselsOf draft={draft} vessels={vessels} wrong={form.at("vessels")} change={change} />
      {field("purpose", t("Purpose"), (marks) => <textarea {...marks} rows={2} value={draft.purpose} onInput={(event) => change({ purpose: event.currentTarget.value })} />)}
      {field("notes", t("Notes"), (marks) => <textarea {...marks} rows={3} value={draft.notes} onInput={(event) => change({ notes: event.currentTarget.value })} />)}
      <FormEnd of={form.end} save={t("Save")} cancel={cancel} />
    </form>
  );
}

function VesselsOf({ draft, vessels, wrong, change }: Pick<Needs, "draft" | "vessels"> & { readonly wrong: string; change(part: Partial<MissionDraft>): void }) {
  const choose = (address: number, whether: boolean): void => change({ vessels: whether ? [...draft.vessels, address] : draft.vessels.filter((one) => one !== address) });
  return (
    <fieldset class="vessels-of" aria-describedby="mission-vessels-wrong">
      <legend>{t("Vessels")}</legend>
      {vessels.map(([address, called], index) => (
        <label key={address} class="inline"><input {...(index === 0 ? { id: "mission-vessels" } : {})} type="checkbox" checked={draft.vessels.includes(address)} onChange={(event) => choose(address, event.currentTarget.checked)} />{called}</label>
      ))}
      {vessels.length === 0 && <p>{t("No vessel is known yet. An admin names vessels under Admin, Vessels.")}</p>}
      <p id="mission-vessels-wrong" class="wrong" role="alert">{wrong}</p>
    </fieldset>
  );
}
