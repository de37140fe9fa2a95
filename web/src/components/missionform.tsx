// The form of a mission. What is wrong is said at its field.

import { useEffect, useRef, useState } from "preact/hooks";
import { type MissionDraft, missionWrong } from "../state/missions";
import type { Wrong } from "../state/notes";
import { sendingText } from "../state/sending";
import { t } from "../words/words";

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
  const [draft, set] = useState(first);
  const [wrong, told] = useState<Wrong | undefined>(undefined);
  const [busy, work] = useState(false);
  const [tries, waits] = useState(0);
  const name = useRef<HTMLInputElement>(null);
  useEffect(() => name.current?.focus(), []);
  const change = (part: Partial<MissionDraft>): void => {
    set({ ...draft, ...part });
    told(undefined);
  };
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault();
    if (busy) return;
    let now = missionWrong(draft);
    if (!now) {
      work(true);
      waits(0);
      now = await send(draft, waits);
      work(false);
    }
    told(now);
    if (now) document.getElementById(`mission-${now.field}`)?.focus();
  };
  const choose = (address: number, whether: boolean): void => change({ vessels: whether ? [...draft.vessels, address] : draft.vessels.filter((one) => one !== address) });
  const at = (field: string): string => (wrong?.field === field ? wrong.text : "");
  const marks = (field: string) => ({ id: `mission-${field}`, "aria-invalid": at(field) !== "", "aria-describedby": `mission-${field}-wrong` });
  const Trouble = ({ field }: { readonly field: string }) => <p id={`mission-${field}-wrong`} class="wrong" role="alert">{at(field)}</p>;
  return (
    <form class="note-form" aria-label={label} noValidate onSubmit={(event) => void submit(event)}>
      <div class="filters">
        <div class="field">
          <label for="mission-name">{t("Name")}</label>
          <input ref={name} {...marks("name")} maxLength={120} autocomplete="off" value={draft.name} onInput={(event) => change({ name: event.currentTarget.value })} />
          {Trouble({ field: "name" })}
        </div>
        <div class="field">
          <label for="mission-from_us">{t("From (UTC)")}</label>
          <input {...marks("from_us")} type="datetime-local" step="1" value={draft.from} onInput={(event) => change({ from: event.currentTarget.value })} />
          {Trouble({ field: "from_us" })}
        </div>
        <div class="field">
          <label for="mission-to_us">{t("To (UTC), empty while it goes on")}</label>
          <input {...marks("to_us")} type="datetime-local" step="1" value={draft.to} onInput={(event) => change({ to: event.currentTarget.value })} />
          {Trouble({ field: "to_us" })}
        </div>
        <div class="field">
          <label for="mission-people">{t("People")}</label>
          <input {...marks("people")} maxLength={500} autocomplete="off" value={draft.people} onInput={(event) => change({ people: event.currentTarget.value })} />
          {Trouble({ field: "people" })}
        </div>
      </div>
      <fieldset class="vessels-of" aria-describedby="mission-vessels-wrong">
        <legend>{t("Vessels")}</legend>
        {vessels.map(([address, called], index) => (
          <label key={address} class="inline"><input {...(index === 0 ? { id: "mission-vessels" } : {})} type="checkbox" checked={draft.vessels.includes(address)} onChange={(event) => choose(address, event.currentTarget.checked)} />{called}</label>
        ))}
        {vessels.length === 0 && <p>{t("No vessel is known yet. An admin names vessels under Admin, Vessels.")}</p>}
        {Trouble({ field: "vessels" })}
      </fieldset>
      <div class="field">
        <label for="mission-purpose">{t("Purpose")}</label>
        <textarea {...marks("purpose")} rows={2} value={draft.purpose} onInput={(event) => change({ purpose: event.currentTarget.value })} />
        {Trouble({ field: "purpose" })}
      </div>
      <div class="field">
        <label for="mission-notes">{t("Notes")}</label>
        <textarea {...marks("notes")} rows={3} value={draft.notes} onInput={(event) => change({ notes: event.currentTarget.value })} />
        {Trouble({ field: "notes" })}
      </div>
      <p class="row">
        <button class="main" aria-disabled={busy}>{t("Save")}</button>
        <button type="button" onClick={cancel}>{t("Cancel")}</button>
        <span role="status">{busy ? sendingText(tries) : ""}</span>
        {wrong && !document.getElementById(`mission-${wrong.field}`) && <span class="bad-text" role="alert">{wrong.text}</span>}
      </p>
    </form>
  );
}
