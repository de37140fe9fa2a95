// The form of a dataset's draft. What is wrong is said at its field.

import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import { draftWrong, type Fields, FLAGS, LICENCES, OWN } from "../state/datasets";
import { flagWord } from "../state/flags";
import type { Wrong } from "../state/notes";
import { t } from "../words/words";
import { Choices } from "./choices";
import { Field, FormEnd, type Marks, useFirstFocus, useSent } from "./sentform";
import { WhenField } from "./when";

/** What can be chosen. */
export interface Choosable {
  /** Names of people and projects of the register. */
  readonly people: readonly string[];
  readonly projects: readonly string[];
  /** Addresses and names. */
  readonly vessels: readonly (readonly [string, string])[];
}

interface Needs extends Choosable {
  readonly first: Fields;
  readonly label: string;
  /** Sends it; what is wrong, or nothing where it is done. */
  send(fields: Fields): Promise<Wrong | undefined>;
  cancel?(): void;
}

export function DatasetForm({ first, label, people, projects, vessels, send, cancel }: Needs) {
  const form = useSent<Fields>({ id: "dataset", first, wrongOf: draftWrong, send });
  const { draft, change } = form;
  const title = useRef<HTMLInputElement>(null);
  useFirstFocus(() => title.current);
  const field = (name: string, text: string, input: (marks: Marks) => ComponentChildren) => <Field key={name} id={`dataset-${name}`} label={text} wrong={form.at(name)} input={input} />;
  const line = (name: keyof Fields, marks: Marks, more: object = {}) => <input {...marks} autocomplete="off" value={draft[name] as string} {...more} onInput={(event) => change({ [name]: event.currentTarget.value })} />;
  return (
    <form class="note-form" aria-label={label} noValidate onSubmit={(event) => void form.submit(event)}>
      <fieldset class="part">
        <legend>{t("What it is")}</legend>
        {field("title", t("Title"), (marks) => <input ref={title} {...marks} maxLength={300} autocomplete="off" value={draft.title} onInput={(event) => change({ title: event.currentTarget.value })} />)}
        {field("description", t("Description: how it was made, and what to know before using it"), (marks) => <textarea {...marks} rows={4} value={draft.description} onInput={(event) => change({ description: event.currentTarget.value })} />)}
        <Authors chosen={draft.authors} people={people} wrong={form.at("authors")} choose={(authors) => change({ authors })} />
        <div class="filters">
          {field("publisher", t("Publisher, the institution"), (marks) => line("publisher", marks, { maxLength: 300 }))}
          {field("licence", t("Licence"), (marks) => <select {...marks} value={draft.licence} onChange={(event) => change({ licence: event.currentTarget.value })}>{LICENCES.map(([id, words]) => <option key={id} value={id}>{words}</option>)}<option value={OWN}>{t("own words")}</option></select>)}
          {draft.licence === OWN && field("own", t("What others may do with it"), (marks) => line("ownLicence", marks, { maxLength: 300 }))}
          {field("embargo_until", t("Others get the data from (empty: at once)"), (marks) => <WhenField marks={marks} kind="day" value={draft.embargo} changed={(embargo) => change({ embargo })} />)}
          {field("doi", t("DOI, where it has one"), (marks) => line("doi", marks, { placeholder: "10.5281/zenodo.1234" }))}
        </div>
      </fieldset>
      <fieldset class="part">
        <legend>{t("Which detections")}</legend>
        <div class="filters">
          {field("from_us", t("From (UTC)"), (marks) => <WhenField marks={marks} value={draft.from} changed={(from) => change({ from })} />)}
          {field("to_us", t("To (UTC), empty for until it is published"), (marks) => <WhenField marks={marks} value={draft.to} changed={(to) => change({ to })} />)}
          {field("tags", t("Tags"), (marks) => line("tags", marks, { placeholder: "S256-101, 102" }))}
          <Choices label={t("Vessels")} all={t("All vessels")} options={vessels} chosen={draft.vessels} choose={(chosen) => change({ vessels: chosen })} />
          <Choices label={t("Projects")} all={t("All projects")} options={projects.map((name) => [name, name] as const)} chosen={draft.projects} choose={(chosen) => change({ projects: chosen })} />
          <Choices label={t("Leave out detections that are")} all={t("none")} options={FLAGS.map((code) => [code, flagWord(code)] as const)} chosen={draft.without} choose={(chosen) => change({ without: FLAGS.filter((code) => chosen.includes(code)) })} />
        </div>
        {field("area", t("Area, corners as latitude,longitude with ; between them; empty for everywhere. Draw it in the explorer"), (marks) => line("area", marks, { placeholder: "63.44,10.35;63.46,10.35;63.46,10.42" }))}
        {form.at("vessels") && <p class="wrong" role="alert">{form.at("vessels")}</p>}
        {form.at("projects") && <p class="wrong" role="alert">{form.at("projects")}</p>}
      </fieldset>
      <FormEnd of={form.end} save={t("Save the draft")} cancel={cancel} />
    </form>
  );
}

/** Authors in their order: each can go up, and out. */
function Authors({ chosen, people, wrong, choose }: { readonly chosen: readonly string[]; readonly people: readonly string[]; readonly wrong: string; choose(authors: readonly string[]): void }) {
  const rest = people.filter((name) => !chosen.includes(name));
  const up = (at: number): void => choose(chosen.map((name, here) => (here === at - 1 ? (chosen[at] ?? name) : here === at ? (chosen[at - 1] ?? name) : name)));
  return (
    <div class="field authors">
      <label for="dataset-authors">{t("Authors, in the order in which they are cited")}</label>
      {chosen.length > 0 && <ol>
        {chosen.map((name, at) => (
          <li key={name}>{name} {at > 0 && <button type="button" aria-label={t("{name} one place up", { name })} onClick={() => up(at)}>↑</button>} <button type="button" aria-label={t("Remove {name} from the authors", { name })} onClick={() => choose(chosen.filter((one) => one !== name))}>×</button></li>
        ))}
      </ol>}
      <select id="dataset-authors" value="" aria-invalid={wrong !== ""} aria-describedby="dataset-authors-wrong" onChange={(event) => { if (event.currentTarget.value) choose([...chosen, event.currentTarget.value]); event.currentTarget.value = ""; }}>
        <option value="">{rest.length ? t("Add an author …") : people.length ? t("no more people in the register") : t("no people in the register yet")}</option>
        {rest.map((name) => <option key={name} value={name}>{name}</option>)}
      </select>
      {!people.length && <p class="dim">{t("People are added in the register.")} <a href="/register?kind=person">{t("Register")}</a></p>}
      <p id="dataset-authors-wrong" class="wrong" role="alert">{wrong}</p>
    </div>
  );
}
