// What the forms of notes and missions share: a field with what is wrong with it, and a draft that is sent until it is answered.

import type { ComponentChildren } from "preact";
import { useLayoutEffect, useState } from "preact/hooks";
import type { Wrong } from "../state/notes";
import { sendingText } from "../state/sending";
import { t } from "../words/words";

/** What ties a field to its label and to what is wrong with it. */
export interface Marks {
  readonly id: string;
  readonly "aria-invalid": boolean;
  readonly "aria-describedby": string;
}

export function Field({ id, label, wrong, input }: { readonly id: string; readonly label: string; readonly wrong: string; readonly input: (marks: Marks) => ComponentChildren }) {
  return (
    <div class="field">
      <label for={id}>{label}</label>
      {input({ id, "aria-invalid": wrong !== "", "aria-describedby": `${id}-wrong` })}
      <p id={`${id}-wrong`} class="wrong" role="alert">{wrong}</p>
    </div>
  );
}

export interface Sending<D> {
  /** Puts the ids of two forms on one page apart. */
  readonly id: string;
  readonly first: D;
  wrongOf(draft: D): Wrong | undefined;
  /** Sends it; what is wrong, or nothing where it is done. `waits` is told where nobody answered and it is tried again. */
  send(draft: D, waits: (tries: number) => void): Promise<Wrong | undefined>;
  /** After it was taken. */
  sent?(draft: D): void;
}

/** Leads the focus into a form as soon as it is there, and before another key is heard: later it could take the focus from where
 * the person has gone meanwhile, and an Enter meant for a button would send the form. */
export function useFirstFocus(field: () => HTMLElement | null | undefined): void {
  useLayoutEffect(() => field()?.focus(), []);
}

/** The draft of a form, and what becomes of it. */
export function useSent<D extends object>({ id, first, wrongOf, send, sent }: Sending<D>) {
  const [draft, set] = useState(first);
  const [wrong, told] = useState<Wrong | undefined>(undefined);
  const [busy, work] = useState(false);
  const [tries, waits] = useState(0);
  const change = (part: Partial<D>): void => {
    set((now) => ({ ...now, ...part }));
    told(undefined);
  };
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault();
    if (busy) return;
    let now = wrongOf(draft);
    if (!now) {
      work(true);
      waits(0);
      now = await send(draft, waits);
      work(false);
    }
    told(now);
    if (now) document.getElementById(`${id}-${now.field}`)?.focus();
    else sent?.(draft);
  };
  const at = (field: string): string => (wrong?.field === field ? wrong.text : "");
  const end = { id, busy, tries, wrong };
  return { draft, set, told, change, submit, at, end };
}

/** The buttons of a form, what it does, and what is wrong where no field shows it. */
export function FormEnd({ of: { id, busy, tries, wrong }, save, cancel }: { readonly of: { readonly id: string; readonly busy: boolean; readonly tries: number; readonly wrong: Wrong | undefined }; readonly save: string; readonly cancel?: (() => void) | undefined }) {
  return (
    <p class="row">
      <button class="main" aria-disabled={busy}>{save}</button>
      {cancel && <button type="button" onClick={cancel}>{t("Cancel")}</button>}
      <span role="status">{busy ? sendingText(tries) : ""}</span>
      {wrong && !document.getElementById(`${id}-${wrong.field}`) && <span class="bad-text" role="alert">{wrong.text}</span>}
    </p>
  );
}
