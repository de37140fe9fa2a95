// The register of studies: one list for each kind, its form, and tables in and out.

import { signal } from "@preact/signals";
import { render } from "preact";
import { deleteAt, inEnglish, postJson, putJson, reason } from "../api/http";
import { resource } from "../api/resource";
import type { Recorded, RegisterAnswer, RegisterEntry, RegisterKind } from "../api/types.gen";
import { RegisterForm } from "../components/registerform";
import { RegisterImport } from "../components/registerimport";
import { TwoStep } from "../components/twostep";
import { fieldOf, type Wrong } from "../state/notes";
import { addWord, type Draft, emptyWord, FIELDS, KINDS, kindsWord, nameOf, recordOf, shownOf } from "../state/register";
import { createChrome } from "../ui/chrome";
import { hexAddress } from "../ui/format";
import { t, tn } from "../words/words";

const PATIENCE_MS = 15_000;

/** What is open above the list. */
type Open = { readonly what: "nothing" | "import" } | { readonly what: "form"; readonly entry?: RegisterEntry };

/** What the page knows. */
class Page {
  readonly answer = resource<RegisterAnswer>();
  readonly open = signal<Open>({ what: "nothing" });
  readonly trouble = signal("");

  constructor(readonly kind: RegisterKind) {}

  get all(): readonly RegisterEntry[] {
    return this.answer.value.value?.entries ?? [];
  }

  readonly show = async (): Promise<void> => void (await this.answer.ask("/api/v1/register"));

  readonly close = (): void => void (this.open.value = { what: "nothing" });

  /** Adds an entry, or has one say something else. */
  readonly send = async (draft: Draft, entry?: RegisterEntry): Promise<Wrong | undefined> => {
    const record = recordOf(this.kind, draft, entry?.record);
    try {
      if (entry) await putJson(`/api/v1/register/${entry.id}`, { revision: entry.revision, record }, PATIENCE_MS);
      else await postJson("/api/v1/register", PATIENCE_MS, record);
    } catch (error) {
      return fieldOf(reason(error), inEnglish(error));
    }
    this.close();
    await this.show();
    return undefined;
  };

  readonly remove = async ({ id, revision }: RegisterEntry): Promise<void> => {
    this.trouble.value = "";
    try {
      await deleteAt(`/api/v1/register/${id}?revision=${revision}`, PATIENCE_MS);
      this.close();
    } catch (error) {
      this.trouble.value = reason(error);
    }
    await this.show();
  };
}

type Called = (address: number) => string;

function List({ page, called }: { readonly page: Page; readonly called: Called }) {
  const fields = FIELDS[page.kind].filter(({ listed }) => listed);
  const entries = page.all.filter(({ record }) => record.kind === page.kind);
  return (
    <div class="wide" tabIndex={0} role="region" aria-label={kindsWord(page.kind)}>
      <table class="compact">
        <thead><tr>{[t("Name"), ...fields.map(({ label }) => label), ""].map((head, at) => <th key={at} scope="col">{head}</th>)}</tr></thead>
        <tbody>
          {entries.map((entry) => (
            <tr key={entry.id}>
              <th scope="row">{nameOf(entry.record)}</th>
              {fields.map((field) => <td key={field.name}>{shownOf(entry.record, field, called)}</td>)}
              <td>{entry.may_change && <button type="button" aria-label={t("Change {name}", { name: nameOf(entry.record) })} onClick={() => (page.open.value = { what: "form", entry })}>{t("Change")}</button>}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function Tabs({ kind }: { readonly kind: RegisterKind }) {
  return (
    <nav class="tabs no-print" aria-label={t("Kinds of entries")}>
      {KINDS.map((one) => <a key={one} href={`/register?kind=${one}`} {...(one === kind ? { "aria-current": "page" as const } : {})}>{kindsWord(one)}</a>)}
    </nav>
  );
}

/** What is open above the list: a form, a file, or the buttons that open them. */
function Above({ page, may, vessels }: { readonly page: Page; readonly may: boolean; readonly vessels: readonly (readonly [string, string])[] }) {
  const [open, { kind }] = [page.open.value, page];
  if (open.what === "form") {
    const { entry } = open;
    const label = entry ? t("Change {name}", { name: nameOf(entry.record) }) : addWord(kind);
    return (
      <section>
        <h2>{label}</h2>
        <RegisterForm key={entry?.id ?? "new"} kind={kind} entry={entry} entries={page.all} vessels={vessels} label={label} send={(draft) => page.send(draft, entry)} cancel={page.close} />
        {entry && <div class="row"><TwoStep key={entry.id} word={t("Delete")} kind="danger" question={t("Delete {name} from the register?", { name: nameOf(entry.record) })} act={() => void page.remove(entry)} /></div>}
      </section>
    );
  }
  if (open.what === "import") return <RegisterImport kind={kind} taken={() => void page.show()} close={page.close} />;
  return (
    <p class="row">
      {may && <button type="button" class="main" onClick={() => (page.open.value = { what: "form" })}>{addWord(kind)}</button>}
      {may && <button type="button" onClick={() => (page.open.value = { what: "import" })}>{t("Import a table")}</button>}
      <a class="button" href={`/api/v1/register.csv?kind=${kind}`} download>{t("Download CSV")}</a>
    </p>
  );
}

export function startRegister(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["names"] ?? "{}") as Record<string, string>;
  const [all, some] = [root.dataset["all"] !== undefined, root.dataset["some"] !== undefined];
  const asked = new URLSearchParams(location.search).get("kind");
  const kind = KINDS.find((one) => one === asked) ?? "tag";
  // Researchers of one vessel keep its deployments; all else is the whole fleet's.
  const may = all || (some && kind === "deployment");
  const called = (address: number): string => names[String(address)] ?? hexAddress(address);
  const [page, recorded] = [new Page(kind), resource<Recorded[]>()];
  const Whole = () => {
    const { value, trouble } = page.answer;
    const count = page.all.filter(({ record }) => record.kind === kind).length;
    const vessels = [...new Set([...Object.keys(names), ...(recorded.value.value ?? []).map(({ system }) => String(system))])].map((address) => [address, called(Number(address))] as const);
    return (
      <>
        <Tabs kind={kind} />
        <Above page={page} may={may} vessels={vessels} />
        {(trouble.value || page.trouble.value) && <p class="bad-text" role="alert">{trouble.value || page.trouble.value} {trouble.value && <button type="button" onClick={() => void page.show()}>{t("Try again")}</button>}</p>}
        {value.value && (count ? <><p role="status">{tn(count, "1 entry.", "{n} entries.")}</p><List page={page} called={called} /></> : page.open.value.what !== "form" && <p>{emptyWord(kind, may)}</p>)}
      </>
    );
  };
  root.replaceChildren();
  render(<Whole />, root);
  createChrome({ messages: ["VehicleState"], events: false, every_ms: 500 }, {});
  void page.show();
  if (some) void recorded.ask("/api/v1/recorded");
}
