// The form of a no-go area beside the map that its corners are clicked on.

import type { Signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { PlanPlace } from "../api/types.gen";
import { areaWrong, type AreaDraft, MOST_CORNERS } from "../state/nogo";
import type { Wrong } from "../state/notes";
import { t } from "../words/words";
import { Field, FormEnd, useSent } from "./sentform";

interface Needs {
  readonly draft: AreaDraft;
  readonly corners: Signal<readonly PlanPlace[]>;
  readonly title: string;
  readonly save: string;
  /** The middle of the map. */
  centre(): PlanPlace;
  /** Sends it; what is wrong, or nothing where it is done. */
  send(draft: AreaDraft, waits: (tries: number) => void): Promise<Wrong | undefined>;
  cancel(): void;
}

export function NoGoForm({ draft: first, corners, title, save, centre, send, cancel }: Needs) {
  const form = useSent<AreaDraft>({ id: "nogo", first, wrongOf: (draft) => areaWrong(draft, corners.value), send });
  const { draft, change, at } = form;
  const name = useRef<HTMLInputElement>(null);
  useEffect(() => name.current?.focus(), []);
  const set = (next: readonly PlanPlace[]): void => {
    corners.value = next;
    form.told(undefined);
  };
  const count = corners.value.length;
  return (
    <form class="nogo-form" aria-label={title} noValidate onSubmit={(event) => void form.submit(event)}>
      <h2>{title}</h2>
      <Field id="nogo-name" label={t("Name")} wrong={at("name")} input={(marks) => <input ref={name} {...marks} maxLength={80} autocomplete="off" value={draft.name} onInput={(event) => change({ name: event.currentTarget.value })} />} />
      <Field id="nogo-reason" label={t("Why it is closed")} wrong={at("reason")} input={(marks) => <textarea {...marks} rows={2} maxLength={500} value={draft.reason} onInput={(event) => change({ reason: event.currentTarget.value })} />} />
      <fieldset>
        <legend>{t("Corners")}</legend>
        <p role="status">{t("Click the corners on the map, in order: {n} so far.", { n: count })}</p>
        <div class="row" id="nogo-corners" tabIndex={-1}>
          <button type="button" disabled={count >= MOST_CORNERS} onClick={() => set([...corners.value, centre()])}>{t("Corner in the middle of the map")}</button>
          <button type="button" disabled={!count} onClick={() => set(corners.value.slice(0, -1))}>{t("Remove the last corner")}</button>
          <button type="button" disabled={!count} onClick={() => set([])}>{t("Remove all corners")}</button>
        </div>
        <p class="wrong" role="alert">{at("corners")}</p>
      </fieldset>
      <FormEnd of={form.end} save={save} cancel={cancel} />
    </form>
  );
}
