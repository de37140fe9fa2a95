// One dataset: its draft, to be changed and published, and what is published, to be cited, downloaded and given to others.

import { signal } from "@preact/signals";
import { render } from "preact";
import { useEffect, useMemo } from "preact/hooks";
import { getText, postJson, putJson, reason } from "../api/http";
import { resource } from "../api/resource";
import type { Dataset, DatasetCheck, DatasetVersion, Recorded, RegisterAnswer } from "../api/types.gen";
import { DatasetForm } from "../components/datasetform";
import { DatasetShares } from "../components/datasetshares";
import { TwoStep } from "../components/twostep";
import { draftOf, type Fields, fieldsOf, LICENCES, placeWords, queryWords, stateWord, timeWords, wrongOfWords } from "../state/datasets";
import { flagWord } from "../state/flags";
import type { Wrong } from "../state/notes";
import { FORMATS } from "../state/register";
import { bytesText } from "../state/takeout";
import { createChrome } from "../ui/chrome";
import { hexAddress, utc } from "../ui/format";
import { count, t, tn } from "../words/words";
import { choosableOf } from "./datasets";

/** The server counts and hashes all rows when it publishes, ms. */
const PATIENCE_MS = 120_000;

class Page {
  readonly dataset = resource<Dataset>();
  readonly register = resource<RegisterAnswer>();
  readonly recorded = resource<Recorded[]>();
  readonly trouble = signal("");
  readonly busy = signal(false);
  readonly saved = signal(false);
  readonly withdrawing = signal(false);
  readonly number = signal(Number(new URLSearchParams(location.search).get("version")) || 0);

  constructor(readonly id: number, readonly names: Readonly<Record<string, string>>) {}

  get way(): string {
    return `/api/v1/datasets/${this.id}`;
  }

  readonly called = (address: number): string => this.names[String(address)] ?? hexAddress(address);

  readonly show = async (): Promise<void> => {
    const found = await this.dataset.ask(this.way);
    if (found?.may_change && found.draft && !this.register.value.value) {
      await Promise.all([this.register.ask("/api/v1/register"), this.recorded.ask("/api/v1/recorded")]);
    }
  };

  readonly save = async (fields: Fields): Promise<Wrong | undefined> => {
    const { value } = this.dataset.value;
    if (!value) return undefined;
    try {
      const draft = draftOf(fields, value.draft ?? undefined);
      await putJson(this.way, { revision: value.revision, draft }, PATIENCE_MS);
      // Not before the page has what was saved: what is done next is done to that.
      await this.show();
      this.saved.value = true;
      return undefined;
    } catch (error) {
      return wrongOfWords(reason(error));
    }
  };

  /** Publishes the draft, or makes one of the newest version. */
  readonly step = async (what: "publish" | "versions"): Promise<void> => {
    const { value } = this.dataset.value;
    if (!value || this.busy.value) return;
    await this.tell(`${this.way}/${what}`, { revision: value.revision });
    if (what === "publish" && !this.trouble.value) this.number.value = 0;
  };

  readonly withdraw = async (words: string): Promise<void> => {
    const { value } = this.dataset.value;
    if (value) await this.tell(`${this.way}/withdraw`, { revision: value.revision, reason: words });
    if (!this.trouble.value) this.withdrawing.value = false;
  };

  private async tell(path: string, body: object): Promise<void> {
    [this.busy.value, this.trouble.value, this.saved.value] = [true, "", false];
    try {
      await postJson(path, PATIENCE_MS, body);
    } catch (error) {
      this.trouble.value = wrongOfWords(reason(error)).text;
    }
    await this.show();
    this.busy.value = false;
  }
}

function Draft({ page, dataset }: { readonly page: Page; readonly dataset: Dataset }) {
  const { draft, versions } = dataset;
  if (!draft || !dataset.may_change || dataset.state === "withdrawn") return null;
  const next = (versions[0]?.number ?? 0) + 1;
  return (
    <section aria-label={t("Draft")}>
      <h2>{t("Draft of version {n}", { n: next })}</h2>
      {page.register.value.value && page.recorded.value.value && <DatasetForm first={fieldsOf(draft)} label={t("Draft")} {...choosableOf(page.register.value.value, page.recorded.value.value, page.names)} send={page.save} />}
      <p role="status">{page.saved.value ? t("Saved.") : ""}</p>
      <div class="row"><TwoStep word={t("Publish version {n}", { n: next })} kind="main" question={t("Publish it? What is published never changes.")} busy={page.busy.value} act={() => void page.step("publish")} /><span role="status">{page.busy.value ? t("Counting and hashing …") : ""}</span></div>
      <p class="dim">{t("Publishing takes the draft as it was saved. It freezes the question, counts the detections and computes the SHA-256 of the CSV.")}</p>
    </section>
  );
}

/** Whether the archive still gives what was published. */
function Check({ page, number }: { readonly page: Page; readonly number: number }) {
  const check = useMemo(() => resource<DatasetCheck>(PATIENCE_MS), [number]);
  useEffect(() => void check.ask(`${page.way}/versions/${number}/check`), [check]);
  const { value } = check.value;
  if (check.busy.value) return <p role="status">{t("Checking whether the archive still gives these bytes …")}</p>;
  if (!value) return check.trouble.value ? <p class="note">{t("Not checked: {why}", { why: check.trouble.value })}</p> : null;
  if (value.is_same) return <p class="note" role="status">{t("Checked {time}: the archive gives exactly these bytes.", { time: utc(value.checked_us) })}</p>;
  if (value.written_by) return <p class="note" role="status">{t("These bytes were written by {by}, and this version of Lutra writes others. Whether the archive has changed is not known.", { by: value.written_by })}</p>;
  const then = count(value.rows);
  return <p class="note warn" role="status">{value.rows === value.rows_now ? t("The archive or the register has changed since: {then} rows then and now, but other bytes.", { then }) : t("The archive has changed since: {then} rows then, {now} now.", { then, now: count(value.rows_now) })}</p>;
}

function Version({ page, version }: { readonly page: Page; readonly version: DatasetVersion }) {
  const { content } = version;
  const licence = LICENCES.find(([id]) => id === version.licence)?.[1] ?? version.licence;
  const called = new Map(version.vessels.map(({ system, name }) => [system, name]));
  const words = queryWords(version.query, (address) => called.get(address) || page.called(address), flagWord);
  const facts: readonly (readonly [string, string])[] = [
    [t("How to cite it"), version.citation],
    [t("Authors"), version.authors.map(({ name, orcid, affiliation }) => [name, affiliation, orcid].filter(Boolean).join(", ")).join("; ")],
    [t("Licence"), licence],
    [t("Embargo"), version.embargo_until ? t("Others get the data from {day}, 00:00 UTC.", { day: version.embargo_until }) : t("none")],
    [t("DOI"), version.doi || t("none")],
    [t("Which detections"), words.join(". ")],
    [t("Detections"), count(content.rows)],
    [t("Time covered"), timeWords(content)],
    [t("Area covered"), placeWords(content)],
    [t("Published"), t("{time} by {name}", { time: utc(version.published.time_us), name: version.published.by })],
  ];
  return (
    <section aria-label={t("Version {n}", { n: version.number })}>
      {version.description && <p class="words">{version.description}</p>}
      <dl class="facts">
        {facts.map(([name, text]) => [<dt key={name}>{name}</dt>, <dd key={`${name} is`}>{text}</dd>])}
        <dt>{t("SHA-256 of the CSV")}</dt><dd><code class="hash">{content.sha256}</code></dd>
      </dl>
    </section>
  );
}

function Downloads({ page, version }: { readonly page: Page; readonly version: DatasetVersion }) {
  const format = useMemo(() => signal("lutra"), []);
  const way = `${page.way}/versions/${version.number}`;
  const formats = FORMATS.filter(([name]) => name !== "actel-biometrics");
  return (
    <section aria-label={t("Download")}>
      <h2>{t("Download")}</h2>
      <p class="row"><label class="inline">{t("Format")} <select value={format.value} onChange={(event) => (format.value = event.currentTarget.value)}>{formats.map(([name, about]) => <option key={name} value={name}>{about}</option>)}</select></label><a class="button main" href={`${way}/detections.csv${format.value === "lutra" ? "" : `?format=${format.value}`}`} download>{t("Download CSV")}{format.value === "lutra" ? ` (${bytesText(version.content.bytes)})` : ""}</a></p>
      <p>{t("For programs:")} {["datapackage.json", "datacite.json", "schema.jsonld"].map((name) => <span key={name}><a href={`${way}/${name}`} download={name}>{name}</a> </span>)}</p>
      <Notebook key={version.number} way={way} />
    </section>
  );
}

/** Lines that fetch exactly this version. */
function Notebook({ way }: { readonly way: string }) {
  const lines = useMemo(() => signal<readonly (readonly [string, string])[]>([]), []);
  const trouble = useMemo(() => signal(""), []);
  useEffect(() => {
    const names = [["Python", "py"], ["R", "R"]] as const;
    void Promise.all(names.map(async ([name, end]) => [name, await getText(`${way}/notebook.${end}`)] as const)).then((all) => (lines.value = all), (error: unknown) => (trouble.value = reason(error)));
  }, [way]);
  return (
    <details>
      <summary>{t("In a notebook")}</summary>
      {trouble.value && <p class="bad-text" role="alert">{trouble.value}</p>}
      <p>{t("LUTRA_TOKEN is a token of yours, made at Account.")} <a href="/account">{t("Account")}</a></p>
      {lines.value.map(([name, text]) => <div key={name}><h3>{name}</h3><pre class="lines" tabIndex={0}><code>{text}</code></pre></div>)}
    </details>
  );
}

function Withdraw({ page }: { readonly page: Page }) {
  const words = useMemo(() => signal(""), []);
  if (!page.withdrawing.value) return <p><button type="button" class="danger" onClick={() => (page.withdrawing.value = true)}>{t("Withdraw the dataset")}</button></p>;
  return (
    <form class="note-form" aria-label={t("Withdraw the dataset")} onSubmit={(event) => { event.preventDefault(); void page.withdraw(words.value); }}>
      <p>{t("It stays in the list, with the reason. Its links stop working, and its data are no longer available. This cannot be undone.")}</p>
      <label for="withdraw-reason">{t("Reason, for those who cited it")}</label>
      <textarea id="withdraw-reason" rows={2} required value={words.value} onInput={(event) => (words.value = event.currentTarget.value)} />
      <p class="row"><button class="danger">{t("Withdraw")}</button><button type="button" onClick={() => (page.withdrawing.value = false)}>{t("Cancel")}</button></p>
    </form>
  );
}

function Whole({ page }: { readonly page: Page }) {
  const { value: dataset } = page.dataset.value;
  const trouble = page.trouble.value || page.dataset.trouble.value;
  if (!dataset) return trouble ? <p class="bad-text" role="alert">{trouble} <button type="button" onClick={() => void page.show()}>{t("Try again")}</button></p> : <p role="status">{t("Fetching …")}</p>;
  const { versions, state, may_change, withdrawn } = dataset;
  const version = versions.find(({ number }) => number === page.number.value) ?? versions[0];
  const title = version?.title || dataset.draft?.title || t("Dataset without a title");
  return (
    <article class="dataset">
      <h1>{title}</h1>
      <p class="dim">{stateWord(state)}{version ? `, ${t("version {n}", { n: version.number })}` : ""} · {t("made {time} by {name}", { time: utc(dataset.made.time_us), name: dataset.made.by })}</p>
      {withdrawn && <p class="note warn">{t("Withdrawn {time} by {name}: {reason}", { time: utc(withdrawn.written.time_us), name: withdrawn.written.by, reason: withdrawn.reason })}</p>}
      {trouble && <p class="bad-text" role="alert">{trouble}</p>}
      {versions.length > 1 && <p><label class="inline">{tn(versions.length, "1 version", "{n} versions")} <select value={String(version?.number)} onChange={(event) => (page.number.value = Number(event.currentTarget.value))}>{versions.map(({ number, published }) => <option key={number} value={String(number)}>{t("version {n}", { n: number })}, {utc(published.time_us)}</option>)}</select></label></p>}
      <Draft page={page} dataset={dataset} />
      {version && (withdrawn && !may_change ? <p class="words">{version.citation}</p> : <Version page={page} version={version} />)}
      {version && may_change && !withdrawn && <><Check key={version.number} page={page} number={version.number} /><Downloads page={page} version={version} /></>}
      {version && may_change && <DatasetShares dataset={dataset.id} version={version.number} may={!withdrawn} />}
      {may_change && !withdrawn && version && !dataset.draft && <section><h2>{t("New version")}</h2><p><button type="button" aria-disabled={page.busy.value} onClick={() => void page.step("versions")}>{t("Make a new version")}</button></p></section>}
      {may_change && !withdrawn && <Withdraw page={page} />}
    </article>
  );
}

export function startDataset(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["names"] ?? "{}") as Record<string, string>;
  const page = new Page(Number(root.dataset["id"]), names);
  root.replaceChildren();
  render(<Whole page={page} />, root);
  createChrome({ messages: ["VehicleState"], events: false, every_ms: 500 }, {});
  void page.show();
}
