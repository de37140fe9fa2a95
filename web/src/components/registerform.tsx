// The form of an entry of the register, made of the fields of its kind. What is wrong is said at its field.

import { useRef } from "preact/hooks";
import type { RegisterEntry, RegisterKind } from "../api/types.gen";
import type { Wrong } from "../state/notes";
import { type Draft, draftOf, type Field as Column, FIELDS, nameOf, registerWrong } from "../state/register";
import { t } from "../words/words";
import { Field, FormEnd, type Marks, useFirstFocus, useSent } from "./sentform";
import { WhenField } from "./when";

export interface RegisterFormNeeds {
  readonly kind: RegisterKind;
  /** The entry that is changed; none where one is added. */
  readonly entry?: RegisterEntry | undefined;
  readonly entries: readonly RegisterEntry[];
  /** Addresses and names of vessels that may be chosen. */
  readonly vessels: readonly (readonly [string, string])[];
  readonly label: string;
  /** Sends it; what is wrong, or nothing where it is done. */
  send(draft: Draft): Promise<Wrong | undefined>;
  cancel(): void;
}

export function RegisterForm({ kind, entry, entries, vessels, label, send, cancel }: RegisterFormNeeds) {
  const form = useSent<Draft>({ id: "register", first: draftOf(kind, entry?.record), wrongOf: (draft) => registerWrong(kind, draft), send });
  const first = useRef<HTMLFormElement>(null);
  useFirstFocus(() => first.current?.querySelector<HTMLElement>("input, select"));
  const { draft, change } = form;
  const input = (column: Column, marks: Marks) => {
    const { name, holds } = column;
    const shared = { ...marks, value: draft[name] ?? "" };
    const typed = (event: { readonly currentTarget: { readonly value: string } }): void => change({ [name]: event.currentTarget.value });
    if (holds === "text") return <textarea {...shared} rows={2} onInput={typed} />;
    if (holds === "time") return <WhenField marks={marks} value={shared.value} changed={(text) => change({ [name]: text })} />;
    if (holds === "line" || holds === "number" || holds === "whole") return <input {...shared} inputMode={holds === "line" ? "text" : "decimal"} autocomplete="off" onInput={typed} />;
    return <select {...shared} onChange={typed}><Choices column={column} chosen={draft[name] ?? ""} entries={entries} vessels={vessels} /></select>;
  };
  const field = (column: Column) => <Field key={column.name} id={`register-${column.name}`} label={column.label} wrong={form.at(column.name)} input={(marks) => input(column, marks)} />;
  const [texts, others] = [FIELDS[kind].filter(({ holds }) => holds === "text"), FIELDS[kind].filter(({ holds }) => holds !== "text")];
  return (
    <form ref={first} class="note-form" aria-label={label} noValidate onSubmit={(event) => void form.submit(event)}>
      <div class="filters">{others.map(field)}</div>
      {texts.map(field)}
      <FormEnd of={form.end} save={t("Save")} cancel={cancel} />
    </form>
  );
}

/** What a field may be chosen from. */
function Choices({ column: { holds }, chosen, entries, vessels }: { readonly column: Column; readonly chosen: string } & Pick<RegisterFormNeeds, "entries" | "vessels">) {
  const names = typeof holds === "object" ? entries.filter(({ record }) => record.kind === holds.ref).map(({ record }) => nameOf(record)) : [];
  const known: readonly (readonly [string, string])[] = holds === "vessel" ? vessels : holds === "sex" ? [["F", t("female")], ["M", t("male")], ["U", t("unknown")]] : names.map((name) => [name, name] as const);
  // Names are the same in whatever case they are written; what stands there is offered too.
  const all = !chosen || known.some(([value]) => value === chosen) ? known : [...known, [chosen, chosen] as const];
  return (
    <>
      <option value="">{t("none")}</option>
      {all.map(([value, name]) => <option key={value} value={value}>{name}</option>)}
    </>
  );
}
