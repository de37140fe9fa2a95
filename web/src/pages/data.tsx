// Taking data away: what was recorded on which day, and files of it, with their size before they are fetched.

import { computed, effect, signal } from "@preact/signals";
import { render } from "preact";
import type { ExportSize, Import, Missions, Recorded, RecordedDay } from "../api/types.gen";
import { type Resource, resource } from "../api/resource";
import { MissionTable } from "../components/missiontable";
import { Recorded as RecordedDays } from "../components/recorded";
import { Spans, TimeSpan } from "../components/timespan";
import { bytesText, canPack, fieldOf, fileOf, hasRows, type Kind, KINDS, logBytes, picked, sizeOf, type Wanted, wrongOf } from "../state/takeout";
import { createChrome } from "../ui/chrome";
import { hexAddress, utc } from "../ui/format";
import { IMPORT_STATES } from "../state/imports";
import { count, t } from "../words/words";

/** After the last change of the form the size is asked for, ms. */
const REST_MS = 350;
/** Missions that are listed here. */
const MISSIONS = 10;

/** What the page knows of what is recorded, and what is wanted of it. */
class TakeOut {
  readonly days = resource<RecordedDay[]>();
  readonly recorded = resource<Recorded[]>();
  readonly size = resource<ExportSize>();
  readonly kind = signal<Kind>("positions");
  readonly message = signal("EstimatedState");
  readonly vessel = signal("");
  readonly from = signal("");
  readonly to = signal("");
  readonly every_s = signal("");
  readonly angles = signal<"deg" | "rad">("deg");
  readonly form = signal<Wanted["form"]>("csv");
  readonly gzip = signal(false);
  readonly wanted = computed<Wanted>(() => ({ kind: this.kind.value, message: this.message.value, vessel: this.vessel.value, from: this.from.value, to: this.to.value, angles: this.angles.value, every_s: this.every_s.value, form: this.form.value, gzip: this.gzip.value }));
  readonly wrong = computed(() => wrongOf(this.wanted.value) ?? (sizeOf(this.wanted.value) && this.size.trouble.value ? fieldOf(this.size.trouble.value) : undefined));
  /** Messages that are recorded of the chosen vessel. */
  readonly messages = computed(() => [...new Set((this.recorded.value.value ?? []).filter((one) => !this.vessel.value || String(one.system) === this.vessel.value).map(({ abbrev }) => abbrev))].sort());
  readonly vessels = computed(() => {
    const all = new Map<number, string>(Object.entries(this.names).map(([address, name]) => [Number(address), name]));
    for (const day of this.days.value.value ?? []) if (!all.has(day.system)) all.set(day.system, this.called(day));
    return [...all].sort(([, one], [, other]) => one.localeCompare(other));
  });

  constructor(private readonly names: Readonly<Record<string, string>>) {}

  readonly called = ({ system, name }: Pick<RecordedDay, "system" | "name">): string => this.names[String(system)] ?? name;

  wrongAt(field: string): string {
    return this.wrong.value?.field === field ? this.wrong.value.text : "";
  }

  readonly choose = (day: RecordedDay): void => {
    // Whole seconds around it, as the date pickers have them.
    [this.vessel.value, this.from.value, this.to.value] = [String(day.system), picked(day.first_us), picked(day.last_us + 1_000_000)];
    document.getElementById("take-out")?.scrollIntoView({ block: "start" });
    document.getElementById("download")?.focus({ preventScroll: true });
  };

  /** Asks for the size when the form has rested. */
  follow(): void {
    let timer = 0;
    effect(() => {
      const path = wrongOf(this.wanted.value) ? "" : sizeOf(this.wanted.value);
      window.clearTimeout(timer);
      timer = window.setTimeout(() => void (path && this.size.ask(path)), REST_MS);
    });
  }
}

interface Part {
  readonly out: TakeOut;
}

function Size({ out: { wrong, kind, days, wanted, size, gzip, form } }: Part) {
  if (wrong.value) return <p role="status">{wrong.value.field ? "" : <span class="bad-text">{wrong.value.text}</span>}</p>;
  if (kind.value === "log") return <p role="status">{t("At most {size}.", { size: bytesText(logBytes(days.value.value ?? [], wanted.value)) })}</p>;
  if (kind.value === "detections") return <p role="status"><a href="/detections">{t("See them first on the page Detections.")}</a></p>;
  if (size.busy.value || !size.value.value) return <p role="status">{t("Looking how large it will be …")}</p>;
  const { rows, bytes } = size.value.value;
  if (rows === 0) return <p role="status">{t("No rows in this time: the file will have its header only.")}</p>;
  if (rows === 1) return <p role="status">{t("One row.")}</p>;
  // The size is that of the text.
  if (form.value === "parquet") return <p role="status">{t("{n} rows.", { n: count(rows) })}</p>;
  const about = { n: count(rows), size: bytesText(bytes) };
  return <p role="status">{gzip.value ? t("{n} rows, about {size} before it is packed.", about) : t("{n} rows, about {size}.", about)}</p>;
}

function Kinds({ out: { kind } }: Part) {
  return (
    <fieldset class="kinds">
      <legend>{t("What")}</legend>
      {KINDS.map(([name, title, about]) => (
        <label key={name} class="kind" data-chosen={kind.value === name ? "" : undefined}>
          <input type="radio" name="kind" value={name} checked={kind.value === name} onChange={() => (kind.value = name)} />
          <span><strong>{title}</strong><span class="about">{about}</span></span>
        </label>
      ))}
    </fieldset>
  );
}

function MessageField({ out }: Part) {
  const { message, messages } = out;
  return (
    <div class="field">
      <label for="message">{t("Message")}</label>
      <input id="message" list="messages" value={message.value} autocomplete="off" spellcheck={false} aria-invalid={out.wrongAt("message") !== ""} aria-describedby="message-wrong" onInput={(event) => (message.value = event.currentTarget.value)} />
      <datalist id="messages">{messages.value.map((name) => <option key={name} value={name} />)}</datalist>
      <p id="message-wrong" class="wrong" role="alert">{out.wrongAt("message")}</p>
    </div>
  );
}

function VesselField({ out }: Part) {
  const { vessel, vessels } = out;
  return (
    <div class="field">
      <label for="of-vessel">{t("Vessel")}</label>
      <select id="of-vessel" value={vessel.value} aria-describedby="vessel-wrong" onChange={(event) => (vessel.value = event.currentTarget.value)}>
        <option value="">{t("All vessels")}</option>
        {vessels.value.map(([address, name]) => <option key={address} value={String(address)}>{name}</option>)}
      </select>
      <p id="vessel-wrong" class="wrong" role="alert">{out.wrongAt("vessel")}</p>
    </div>
  );
}

/** Of files of rows: their form, how angles are written, and how often there is a row. */
function RowFields({ out }: Part) {
  const { angles, every_s, form, kind } = out;
  return (
    <>
      <div class="field">
        <label for="form">{t("File format")}</label>
        <select id="form" value={form.value} onChange={(event) => (form.value = event.currentTarget.value as Wanted["form"])}><option value="csv">{t("CSV")}</option><option value="parquet">{t("Parquet: pandas, R, DuckDB")}</option></select>
      </div>
      <div class="field">
        <label for="angles">{t("Angles")}</label>
        <select id="angles" value={angles.value} onChange={(event) => (angles.value = event.currentTarget.value as "deg" | "rad")}><option value="deg">{t("degrees")}</option><option value="rad">{t("radians")}</option></select>
      </div>
      <div class="field">
        <label for="every">{t("Sampling interval, seconds")}</label>
        <input id="every" inputMode="decimal" value={every_s.value} placeholder={kind.value === "positions" ? "1" : t("every row")} aria-invalid={out.wrongAt("every_s") !== ""} aria-describedby="every-wrong" onInput={(event) => (every_s.value = event.currentTarget.value.trim().replace(",", "."))} />
        <p id="every-wrong" class="wrong" role="alert">{out.wrongAt("every_s")}</p>
      </div>
    </>
  );
}

function Form({ out }: Part) {
  const { kind, from, to, gzip, wrong, wanted } = out;
  return (
    <form class="take-out" onSubmit={(event) => event.preventDefault()} aria-label={t("Files")}>
      <Kinds out={out} />
      <div class="filters">
        {kind.value === "messages" && <MessageField out={out} />}
        <VesselField out={out} />
        <TimeSpan from={from} to={to} fromWrong={out.wrongAt("from")} toWrong={out.wrongAt("to")} />
        {hasRows(kind.value) && <RowFields out={out} />}
      </div>
      <Spans from={from} to={to} />
      {canPack(wanted.value) && <label class="inline"><input type="checkbox" checked={gzip.value} onChange={(event) => (gzip.value = event.currentTarget.checked)} />{t("Compress with gzip")}</label>}
      <div class="fetch">{wrong.value ? <button type="button" id="download" class="main" disabled>{t("Download")}</button> : <a id="download" class="button main" href={fileOf(wanted.value)} download>{t("Download")}</a>}<Size out={out} /></div>
    </form>
  );
}

function Imports({ imports }: { readonly imports: Resource<Import[]> }) {
  const all = imports.value.value;
  return (
    <section>
      <h2>{t("Imported")}</h2>
      {all?.length ? (
        <ul class="imports">{all.map((one) => <li key={one.id}><strong>{one.name}</strong> {t("by {person}, {time}: {n} packets, {state}", { person: one.person, time: utc(one.since_us), n: count(one.packets), state: IMPORT_STATES[one.state] })}</li>)}</ul>
      ) : <p>{imports.trouble.value || t("No log was imported since the server started.")}</p>}
      <p><a href="/admin/import">{t("Import a log")}</a></p>
    </section>
  );
}

function Days({ out: { days, called, choose }, may }: Part & { readonly may: boolean }) {
  const all = days.value.value;
  return (
    <section>
      <h2>{t("Recorded")}</h2>
      {days.trouble.value && <p class="bad-text" role="alert">{days.trouble.value} <button type="button" onClick={() => void days.ask("/api/v1/recorded/days")}>{t("Try again")}</button></p>}
      {all?.length === 0 && <p>{t("Nothing is recorded yet. What a vessel sends is recorded by itself, from its first packet.")}</p>}
      {all?.length ? <RecordedDays days={all} called={called} may={may} choose={choose} /> : null}
    </section>
  );
}

/** The newest missions: what belongs to one is taken away on its own page. */
function RecordedMissions({ missions, called }: { readonly missions: Resource<Missions>; called(address: number): string }) {
  const all = missions.value.value?.missions;
  return (
    <section>
      <h2>{t("Missions")}</h2>
      {missions.trouble.value && <p class="bad-text" role="alert">{missions.trouble.value}</p>}
      {all?.length ? <MissionTable missions={all} called={called} /> : all && <p>{t("No missions yet.")}</p>}
      <p><a href="/missions">{t("All missions")}</a></p>
    </section>
  );
}

export function startData(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["names"] ?? "{}") as Record<string, string>;
  const [may, admin] = [root.dataset["researcher"] !== undefined, root.dataset["admin"] !== undefined];
  const [out, imports, missions] = [new TakeOut(names), resource<Import[]>(), resource<Missions>()];
  const called = (system: number): string => out.called({ system, name: out.vessels.value.find(([address]) => address === system)?.[1] ?? hexAddress(system) });
  if (may) out.follow();
  const Page = () => (
    <>
      {may ? <section id="take-out"><h2>{t("Download")}</h2><Form out={out} /></section> : <p class="note">{t("Downloading data needs the role researcher; an admin gives it.")}</p>}
      <Days out={out} may={may} />
      <RecordedMissions missions={missions} called={called} />
      {admin && <Imports imports={imports} />}
    </>
  );
  root.replaceChildren();
  render(<Page />, root);
  createChrome({ messages: ["VehicleState"], events: false, every_ms: 500 }, {});
  void out.days.ask("/api/v1/recorded/days");
  void out.recorded.ask("/api/v1/recorded");
  void missions.ask(`/api/v1/missions?limit=${MISSIONS}`);
  if (admin) void imports.ask("/api/v1/import");
}
