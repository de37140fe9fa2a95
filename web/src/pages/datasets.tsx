// Datasets: the list, and the form of a new one, which the explorer can fill.

import { signal } from "@preact/signals";
import { render } from "preact";
import { postJson, reason } from "../api/http";
import { resource } from "../api/resource";
import type { Dataset, Recorded, RegisterAnswer } from "../api/types.gen";
import { type Choosable, DatasetForm } from "../components/datasetform";
import { draftOf, type Fields, fieldsOfSearch, stateWord, timeWords, wrongOfWords } from "../state/datasets";
import { knownVessels } from "../state/known";
import type { Wrong } from "../state/notes";
import { createChrome } from "../ui/chrome";
import { hexAddress, utc } from "../ui/format";
import { count, t } from "../words/words";

const PATIENCE_MS = 20_000;

/** What a draft may name: people and projects of the register, vessels with a name or of which something is recorded. */
export function choosableOf(register: RegisterAnswer | undefined, recorded: readonly Recorded[] | undefined, names: Readonly<Record<string, string>>): Choosable {
  const of = (kind: string): readonly string[] => (register?.entries ?? []).filter(({ record }) => record.kind === kind).map(({ record }) => record.name);
  return { people: of("person"), projects: of("project"), vessels: knownVessels(names, recorded ?? []).map((address) => [String(address), names[String(address)] ?? hexAddress(address)] as const) };
}

async function create(fields: Fields): Promise<Wrong | undefined> {
  try {
    const made = await postJson<Dataset>("/api/v1/datasets", PATIENCE_MS, draftOf(fields));
    location.assign(`/datasets/${made.id}`);
    return undefined;
  } catch (error) {
    return wrongOfWords(reason(error));
  }
}

function Table({ all }: { readonly all: readonly Dataset[] }) {
  return (
    <div class="wide" tabIndex={0} role="region" aria-label={t("Datasets")}>
      <table class="compact">
        <thead><tr>{[t("Title"), t("State"), t("Version"), t("Detections"), t("Time covered"), t("Made by"), t("Made")].map((head) => <th key={head} scope="col">{head}</th>)}</tr></thead>
        <tbody>
          {all.map(({ id, state, draft, versions: [newest], made }) => (
            <tr key={id}>
              <th scope="row"><a href={`/datasets/${id}`}>{newest?.title || draft?.title || t("Dataset without a title")}</a></th>
              <td>{stateWord(state)}{newest && draft && state !== "withdrawn" ? `, ${t("with a draft")}` : ""}</td>
              <td class="num">{newest?.number ?? ""}</td>
              <td class="num">{newest?.content.rows ? count(newest.content.rows) : ""}</td>
              <td class="num">{newest?.content.rows ? timeWords(newest.content) : ""}</td>
              <td>{made.by}</td>
              <td class="num">{utc(made.time_us)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

export function startDatasets(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["names"] ?? "{}") as Record<string, string>;
  const may = root.dataset["researcher"] !== undefined;
  const [list, register, recorded] = [resource<Dataset[]>(), resource<RegisterAnswer>(), resource<Recorded[]>()];
  const making = signal(may && new URLSearchParams(location.search).has("make"));
  const first = fieldsOfSearch(location.search);
  const Page = () => {
    const all = list.value.value;
    return (
      <>
        {making.value ? (
          <section>
            <h2>{t("New dataset")}</h2>
            {/* The form begins with what can be chosen. */}
            {register.value.value && <DatasetForm first={first} label={t("New dataset")} {...choosableOf(register.value.value, recorded.value.value, names)} send={create} cancel={() => (making.value = false)} />}
            {register.trouble.value && <p class="bad-text" role="alert">{register.trouble.value} <button type="button" onClick={() => void register.ask("/api/v1/register")}>{t("Try again")}</button></p>}
          </section>
        ) : may && <p><button type="button" class="main" onClick={() => (making.value = true)}>{t("New dataset")}</button></p>}
        {list.trouble.value && <p class="bad-text" role="alert">{list.trouble.value} <button type="button" onClick={() => void list.ask("/api/v1/datasets")}>{t("Try again")}</button></p>}
        {all && all.length > 0 && <Table all={all} />}
        {all?.length === 0 && !making.value && (may
          ? <p>{t("No datasets yet. A dataset is a selection of detections that you describe, publish, cite and share by a link. Select detections in the explorer and press Make a dataset of this, or press New dataset.")} <a href="/explore">{t("Explorer")}</a></p>
          : <p>{t("No datasets yet. Researchers make them.")}</p>)}
      </>
    );
  };
  root.replaceChildren();
  render(<Page />, root);
  createChrome({ messages: ["VehicleState"], events: false, every_ms: 500 }, {});
  void list.ask("/api/v1/datasets");
  if (may) {
    void register.ask("/api/v1/register");
    void recorded.ask("/api/v1/recorded");
  }
}
