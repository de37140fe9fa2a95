// The form of a no-go area beside the map that its corners are clicked on.

import { useRef } from "preact/hooks";
import type { PlanPlace } from "../api/types.gen";
import { type Corners, MOST_CORNERS, textOfCorners } from "../state/corners";
import { areaWrong, type AreaDraft } from "../state/nogo";
import type { Wrong } from "../state/notes";
import { t } from "../words/words";
import { Field, FormEnd, useFirstFocus, useSent } from "./sentform";

interface Needs {
  readonly draft: AreaDraft;
  readonly corners: Corners;
  readonly title: string;
  readonly save: string;
  /** The middle of the map. */
  centre(): PlanPlace;
  /** Brings the corners into view on the map. */
  show(): void;
  /** Sends it; what is wrong, or nothing where it is done. */
  send(draft: AreaDraft, waits: (tries: number) => void): Promise<Wrong | undefined>;
  cancel(): void;
}

export function NoGoForm({ draft: first, corners, title, save, centre, show, send, cancel }: Needs) {
  const form = useSent<AreaDraft>({ id: "nogo", first, wrongOf: (draft) => (corners.take() ? areaWrong(draft, corners.now.value) : { field: "text", text: corners.wrong.value }), send });
  const { draft, change, at } = form;
  const name = useRef<HTMLInputElement>(null);
  useFirstFocus(() => name.current);
  const act = (work: () => void): void => {
    work();
    form.told(undefined);
  };
  const now = corners.now.value;
  const count = now.length;
  return (
    <form class="nogo-form" aria-label={title} noValidate onSubmit={(event) => void form.submit(event)}>
      <h2>{title}</h2>
      <Field id="nogo-name" label={t("Name")} wrong={at("name")} input={(marks) => <input ref={name} {...marks} maxLength={80} autocomplete="off" value={draft.name} onInput={(event) => change({ name: event.currentTarget.value })} />} />
      <Field id="nogo-reason" label={t("Why it is closed")} wrong={at("reason")} input={(marks) => <textarea {...marks} rows={2} maxLength={500} value={draft.reason} onInput={(event) => change({ reason: event.currentTarget.value })} />} />
      <fieldset>
        <legend>{t("Corners")}</legend>
        <p role="status">{t("Click the corners on the map, in order: {n} so far.", { n: count })}</p>
        <p class="dim">{t("Drag a corner to move it, and the dot on a side to make a new corner there.")}</p>
        <div class="row" id="nogo-corners" tabIndex={-1}>
          <button type="button" disabled={count >= MOST_CORNERS} onClick={() => act(() => corners.add(centre()))}>{t("Corner in the middle of the map")}</button>
          <button type="button" disabled={!corners.changed} onClick={() => act(() => corners.undo())}>{t("Undo")}</button>
          <button type="button" disabled={!count} onClick={() => act(() => corners.set(now.slice(0, -1)))}>{t("Remove the last corner")}</button>
          <button type="button" disabled={!count} onClick={() => act(() => corners.set([]))}>{t("Remove all corners")}</button>
        </div>
        <CornersAsText corners={corners} taken={() => act(show)} />
        <p class="wrong" role="alert">{at("corners")}</p>
      </fieldset>
      <FormEnd of={form.end} save={save} cancel={cancel} />
    </form>
  );
}

/** The corners to be read, typed and pasted; what is typed counts once it is places. */
function CornersAsText({ corners, taken }: { readonly corners: Corners; readonly taken: () => void }) {
  const { typed, wrong } = corners;
  const take = (): void => {
    if (corners.take()) taken();
  };
  // While the text is not what the area has for corners, it is not hidden.
  const shown = (details: HTMLDetailsElement): void => {
    details.open ||= wrong.value !== "";
  };
  return (
    <details onToggle={(event) => shown(event.currentTarget)}>
      <summary>{t("Corners as text")}</summary>
      <Field id="nogo-text" label={t("A corner in each line: latitude, longitude")} wrong={wrong.value} input={(marks) => <textarea {...marks} class="num" rows={6} spellcheck={false} value={typed.value ?? textOfCorners(corners.now.value)} onInput={(event) => { typed.value = event.currentTarget.value; }} onChange={take} />} />
    </details>
  );
}
