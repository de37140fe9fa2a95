// A table of the register as a file: what it would change is shown, with all that is wrong, before it is taken whole.

import { useRef, useState } from "preact/hooks";
import { postJson, reason } from "../api/http";
import type { RegisterImport as Told, RegisterKind } from "../api/types.gen";
import { importText } from "../state/register";
import { t, tn, withWords, worded } from "../words/words";

const PATIENCE_MS = 60_000;
/** Lines that are shown; the counts are of all. */
const SHOWN = 200;

interface Needs {
  readonly kind: RegisterKind;
  /** After it was taken. */
  taken(): void;
  close(): void;
}

export function RegisterImport({ kind, taken, close }: Needs) {
  const file = useRef<HTMLInputElement>(null);
  const [told, tell] = useState<Told | undefined>(undefined);
  const [trouble, fail] = useState("");
  const [busy, work] = useState(false);
  const ask = async (version?: number): Promise<void> => {
    const chosen = file.current?.files?.[0];
    if (!chosen || busy) return;
    work(true);
    fail("");
    const query = new URLSearchParams({ kind, ...(version === undefined ? {} : { apply: "true", version: String(version) }) });
    try {
      const answer = await postJson<Told>(`/api/v1/register/import?${query}`, PATIENCE_MS, chosen);
      await withWords(...answer.problems.map(({ says }) => says));
      tell(answer);
      if (answer.applied) taken();
    } catch (error) {
      fail(reason(error));
    }
    work(false);
  };
  const may = told && !told.applied && !told.problems.length && told.added + told.changed > 0;
  return (
    <section aria-label={t("Import a table")}>
      <h2>{t("Import a table")}</h2>
      <p>{t("A CSV file with a line for each entry; its first line names the columns. A line changes the entry of its name, or adds one; columns that the file does not have stay as they are. Nothing is changed before you have seen it.")} <a href={`/api/v1/register.csv?kind=${kind}`} download>{t("Template, with what is there")}</a></p>
      <div class="row">
        <label>{t("File")} <input ref={file} type="file" accept=".csv,text/csv" onChange={() => { tell(undefined); void ask(); }} /></label>
        {may && <button type="button" class="main" aria-disabled={busy} onClick={() => void ask(told.version)}>{t("Import into the register")}</button>}
        <button type="button" onClick={close}>{t("Close")}</button>
      </div>
      <p role="status">{busy ? t("Reading …") : told ? (told.applied ? `${t("Imported.")} ${importText(told)}` : importText(told)) : ""}</p>
      {trouble && <p class="bad-text pre" role="alert">{trouble}</p>}
      {told && told.problems.length > 0 && <Problems told={told} />}
      {told && !told.applied && told.changes.length > 0 && <Changes told={told} />}
    </section>
  );
}

function Problems({ told: { problems } }: { readonly told: Told }) {
  return (
    <div role="alert">
      <p class="bad-text">{tn(problems.length, "1 problem: correct it in the file and choose it again. Nothing was imported.", "{n} problems: correct them in the file and choose it again. Nothing was imported.")}</p>
      <div class="wide" tabIndex={0} role="region" aria-label={t("What is wrong")}>
        <table class="compact">
          <thead><tr>{[t("Line"), t("Column"), t("What is wrong")].map((head) => <th key={head} scope="col">{head}</th>)}</tr></thead>
          <tbody>{problems.slice(0, SHOWN).map(({ line, column, text, says }, at) => <tr key={at}><td class="num">{line ?? ""}</td><td><code>{column}</code></td><td>{worded({ text, says })}</td></tr>)}</tbody>
        </table>
      </div>
    </div>
  );
}

function Changes({ told: { changes } }: { readonly told: Told }) {
  return (
    <div class="wide" tabIndex={0} role="region" aria-label={t("What is changed")}>
      <table class="compact">
        <thead><tr>{[t("Line"), t("Name"), t("What is changed")].map((head) => <th key={head} scope="col">{head}</th>)}</tr></thead>
        <tbody>
          {changes.slice(0, SHOWN).map(({ line, name, is_new, fields }) => (
            <tr key={line}><td class="num">{line}</td><td>{name}</td><td>{is_new ? t("new") : fields.map(({ column, before, after }) => `${column}: ${before || "–"} → ${after || "–"}`).join("; ")}</td></tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
