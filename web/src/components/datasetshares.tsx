// Links by which others get a dataset: what there are, how they were used, and a new one, whose address is shown once.

import { signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useMemo } from "preact/hooks";
import { deleteAt, postJson, reason } from "../api/http";
import { resource } from "../api/resource";
import type { DatasetShare, DatasetShareMade, ShareVisit } from "../api/types.gen";
import { NEW_SHARE, shareAsk, type ShareFields, shareWords, shareWrong, visitWord, wrongOfWords } from "../state/datasets";
import type { Wrong } from "../state/notes";
import { utc } from "../ui/format";
import { t, tn } from "../words/words";
import { Field, FormEnd, type Marks, useSent } from "./sentform";
import { TwoStep } from "./twostep";
import { WhenField } from "./when";

/** The server counts and hashes what a link gives before it answers, ms. */
const PATIENCE_MS = 120_000;

class Links {
  readonly all = resource<DatasetShare[]>();
  readonly visits = resource<ShareVisit[]>();
  /** The link whose uses are shown. */
  readonly shown = signal(0);
  readonly making = signal(false);
  readonly made = signal<DatasetShareMade | undefined>(undefined);
  readonly trouble = signal("");
  readonly said = signal("");

  constructor(readonly way: string) {}

  readonly show = async (): Promise<void> => void (await this.all.ask(this.way));

  readonly make = async (fields: ShareFields, version: number): Promise<Wrong | undefined> => {
    try {
      this.made.value = await postJson<DatasetShareMade>(this.way, PATIENCE_MS, shareAsk(fields, version));
      [this.making.value, this.said.value] = [false, ""];
      await this.show();
      return undefined;
    } catch (error) {
      return wrongOfWords(reason(error));
    }
  };

  readonly revoke = async ({ id }: DatasetShare): Promise<void> => {
    this.trouble.value = "";
    try {
      await deleteAt(`${this.way}/${id}`, PATIENCE_MS);
      if (this.made.value?.share.id === id) this.made.value = undefined;
    } catch (error) {
      this.trouble.value = reason(error);
    }
    await this.show();
  };

  readonly look = (id: number): void => {
    this.shown.value = this.shown.value === id ? 0 : id;
    // The counts beside them are of the same moment.
    if (this.shown.value) void Promise.all([this.visits.ask(`${this.way}/${id}/visits`), this.show()]);
  };

  readonly copy = async (address: string): Promise<void> => {
    try {
      await navigator.clipboard.writeText(address);
      this.said.value = t("Copied.");
    } catch {
      this.said.value = t("Mark the address, and copy it with Ctrl and C.");
    }
  };
}

export function DatasetShares({ dataset, version, may }: { readonly dataset: number; readonly version: number; readonly may: boolean }) {
  const links = useMemo(() => {
    const made = new Links(`/api/v1/datasets/${dataset}/shares`);
    void made.show();
    return made;
  }, [dataset]);
  const all = links.all.value.value ?? [];
  const trouble = links.trouble.value || links.all.trouble.value;
  return (
    <section aria-label={t("Links for others")}>
      <h2>{t("Links for others")}</h2>
      <p>{t("A link gives this version to others, with or without an account: all of it, or a part, or with coarsened places. Each use is listed here.")}</p>
      {links.made.value && <Made links={links} made={links.made.value} />}
      {may && (links.making.value ? <ShareForm links={links} version={version} /> : <p><button type="button" class="main" onClick={() => { links.making.value = true; links.made.value = undefined; }}>{t("Make a link")}</button></p>)}
      {trouble && <p class="bad-text" role="alert">{trouble}</p>}
      {all.length > 0 && <Table links={links} all={all} />}
      {!all.length && links.all.value.value && <p>{t("No links yet.")}</p>}
    </section>
  );
}

/** The address of a new link. */
function Made({ links, made }: { readonly links: Links; readonly made: DatasetShareMade }) {
  const address = `${location.origin}${made.path}`;
  return (
    <div class="note good" role="status">
      <p>{made.share.person ? t("The link for {name}. It opens after logging in as {account}, who also finds it under Shared with you.", { name: made.share.label, account: made.share.person }) : t("The link for {name}. Copy it now: it is shown this once.", { name: made.share.label })}</p>
      <p><code class="secret">{address}</code></p>
      <p class="row"><button type="button" onClick={() => void links.copy(address)}>{t("Copy")}</button><span class="dim" role="status">{links.said.value}</span></p>
      {made.share.had_changed && <p class="warn">{t("When this link was made, the archive gave other bytes than were published as this version.")} {t("Its page says so too.")}</p>}
      {made.share.has_password && <p>{t("Give the password by another way than the link.")}</p>}
    </div>
  );
}

function ShareForm({ links, version }: { readonly links: Links; readonly version: number }) {
  const form = useSent<ShareFields>({ id: "share", first: NEW_SHARE, wrongOf: shareWrong, send: (fields) => links.make(fields, version) });
  const { draft, change } = form;
  const field = (name: string, text: string, input: (marks: Marks) => ComponentChildren) => <Field key={name} id={`share-${name}`} label={text} wrong={form.at(name)} input={input} />;
  const line = (name: keyof ShareFields, marks: Marks, more: object = {}) => <input {...marks} autocomplete="off" value={draft[name]} {...more} onInput={(event) => change({ [name]: event.currentTarget.value })} />;
  return (
    <form class="note-form" aria-label={t("Make a link")} noValidate onSubmit={(event) => void form.submit(event)}>
      <div class="filters">
        {field("label", t("Recipient"), (marks) => line("label", marks, { maxLength: 100 }))}
        {field("days", t("Days until it ends"), (marks) => line("days", marks, { inputMode: "numeric" }))}
        {field("person", t("Only for this account (empty for anyone with the address)"), (marks) => line("person", marks, { maxLength: 64, spellcheck: false, autocapitalize: "none" }))}
        {field("password", t("Password (empty for none)"), (marks) => line("password", marks, { spellcheck: false, autocapitalize: "none" }))}
        {field("precision_m", t("Places"), (marks) => (
          <select {...marks} value={draft.precision} onChange={(event) => change({ precision: event.currentTarget.value })}>
            <option value="">{t("as they are")}</option>
            {[100, 1_000, 10_000].map((n) => <option key={n} value={String(n)}>{t("coarsened to about {n} m", { n })}</option>)}
          </select>
        ))}
      </div>
      <details><summary>{t("Only a part of it")}</summary>
        <div class="filters">
          {field("from_us", t("From (UTC)"), (marks) => <WhenField marks={marks} value={draft.from} changed={(from) => change({ from })} />)}
          {field("to_us", t("To (UTC)"), (marks) => <WhenField marks={marks} value={draft.to} changed={(to) => change({ to })} />)}
          {field("tags", t("Tags"), (marks) => line("tags", marks, { placeholder: "S256-101, 102" }))}
          {field("area", t("Area, corners as latitude,longitude with ; between them"), (marks) => line("area", marks, { placeholder: "63.44,10.35;63.46,10.35;63.46,10.42" }))}
        </div>
      </details>
      <FormEnd of={form.end} save={t("Make the link")} cancel={() => (links.making.value = false)} />
    </form>
  );
}

function Table({ links, all }: { readonly links: Links; readonly all: readonly DatasetShare[] }) {
  const now = Date.now() * 1_000;
  const state = (one: DatasetShare): string => (one.revoked ? t("revoked") : one.expires_us <= now ? t("ended") : t("until {time}", { time: utc(one.expires_us) }));
  return (
    <div class="wide" tabIndex={0} role="region" aria-label={t("Links")}>
      <table class="compact">
        <thead><tr>{[t("Recipient"), t("What it gives"), t("Version"), t("State"), t("Used"), ""].map((head, at) => <th key={at} scope="col">{head}</th>)}</tr></thead>
        <tbody>
          {all.map((one) => [
            <tr key={one.id}>
              <th scope="row">{one.label}</th>
              <td>{shareWords(one)}</td>
              <td class="num">{one.version}</td>
              <td>{state(one)}</td>
              <td>{tn(one.views, "1 view", "{n} views")}, {tn(one.downloads, "1 download", "{n} downloads")}{one.used_us === null ? "" : ` (${utc(one.used_us)})`}</td>
              <td class="row">
                <button type="button" aria-expanded={links.shown.value === one.id} aria-label={t("Uses of the link for {name}", { name: one.label })} onClick={() => links.look(one.id)}>{t("Uses")}</button>
                {!one.revoked && <TwoStep word={t("Revoke")} label={t("Revoke the link for {name}", { name: one.label })} kind="danger" question={t("Revoke the link for {name}? It stops working at once.", { name: one.label })} act={() => void links.revoke(one)} />}
              </td>
            </tr>,
            links.shown.value === one.id && <tr key={`${one.id} uses`}><td colSpan={6}><Uses links={links} /></td></tr>,
          ])}
        </tbody>
      </table>
    </div>
  );
}

function Uses({ links }: { readonly links: Links }) {
  const { value, trouble, busy } = links.visits;
  if (trouble.value) return <p class="bad-text" role="alert">{trouble.value}</p>;
  if (busy.value || !value.value) return <p role="status">{t("Fetching …")}</p>;
  if (!value.value.length) return <p>{t("Nobody has used it yet.")}</p>;
  return (
    <ul class="uses">
      {value.value.map(({ time_us, address, what, file }, at) => <li key={at}><span class="num">{utc(time_us)}</span> {visitWord(what)}{file && `: ${file}`}, {t("from {address}", { address })}</li>)}
    </ul>
  );
}
