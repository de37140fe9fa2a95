// One mission: what it was, its replay, its summary, its files and its notes; to be printed.

import { signal } from "@preact/signals";
import { render } from "preact";
import { deleteAt, inEnglish, patchJson, reason } from "../api/http";
import type { LogNotes, Mission, MissionRequest, MissionChange, MissionSummary, MissionVessel, Recorded } from "../api/types.gen";
import { resource } from "../api/resource";
import { MissionForm } from "../components/missionform";
import { NoteList } from "../components/notelist";
import { hoursText, type MissionDraft, missionAsk, missionDraft, missionFile, notesOf, replayOf, trackFile } from "../state/missions";
import { fieldOf, type Wrong } from "../state/notes";
import { asCards } from "../ui/cards";
import { createChrome } from "../ui/chrome";
import { distance, hexAddress, utc } from "../ui/format";
import { count, t } from "../words/words";
import { choosable } from "./missions";

const PATIENCE_MS = 15_000;
/** A summary reads through the whole mission. */
const SUMMARY_PATIENCE_MS = 180_000;

/** What the page knows of its mission, and what becomes of it. */
class Book {
  readonly one = resource<Mission>();
  readonly summary = resource<MissionSummary>(SUMMARY_PATIENCE_MS);
  readonly notes = resource<LogNotes>();
  readonly recorded = resource<Recorded[]>();
  readonly doing = signal<"" | "change" | "withdraw">("");
  readonly trouble = signal("");
  private readonly path: string;

  constructor(id: string) {
    this.path = `/api/v1/missions/${id}`;
  }

  /** The end of the mission; of one that goes on the present. */
  toUs(): number {
    const mission = this.one.value.value?.mission;
    return mission?.to_us ?? Math.max(Date.now() * 1_000, (mission?.from_us ?? 0) + 1);
  }

  async askNotes(): Promise<void> {
    const known = this.one.value.value;
    if (known) await this.notes.ask(`/api/v1/logbook?${notesOf(known.mission, this.toUs())}&limit=500`);
  }

  askSummary(): void {
    void this.summary.ask(`${this.path}/summary`);
  }

  async learn(): Promise<void> {
    if (!(await this.one.ask(this.path))) return;
    void this.askNotes();
    this.askSummary();
  }

  readonly change = async (draft: MissionDraft): Promise<Wrong | undefined> => {
    const known = this.one.value.value;
    if (!known) return undefined;
    try {
      const mission = exactly(known.mission, draft);
      await patchJson<Mission>(this.path, { revision: known.revision, mission } satisfies MissionChange, PATIENCE_MS);
      this.doing.value = "";
      document.title = t("{name} · Lutra", { name: mission.name });
      void this.learn();
      return undefined;
    } catch (error) {
      return fieldOf(reason(error), inEnglish(error));
    }
  };

  async withdraw(): Promise<void> {
    try {
      await deleteAt(this.path, PATIENCE_MS);
      location.assign("/missions");
    } catch (error) {
      this.trouble.value = reason(error);
    }
  }
}

/** A picker knows whole seconds: what was not touched stays as it is. */
function exactly(mission: MissionRequest, draft: MissionDraft): MissionRequest {
  const [asked, before] = [missionAsk(draft), missionDraft(mission)];
  return { ...asked, from_us: draft.from === before.from ? mission.from_us : asked.from_us, to_us: draft.to === before.to ? mission.to_us : asked.to_us };
}

type Called = (address: number) => string;

interface Part {
  readonly book: Book;
  readonly mission: Mission;
  readonly called: Called;
}

function About({ mission: { mission, written, changed, withdrawn }, called }: Part) {
  return (
    <dl class="mission-about">
      <dt>{t("Time (UTC)")}</dt><dd class="num">{mission.to_us === null ? t("{from} to now: it goes on", { from: utc(mission.from_us) }) : t("{from} to {to}", { from: utc(mission.from_us), to: utc(mission.to_us) })}</dd>
      <dt>{t("Vessels")}</dt><dd>{mission.vessels.map(called).join(", ")}</dd>
      {mission.people && <><dt>{t("People")}</dt><dd>{mission.people}</dd></>}
      {mission.purpose && <><dt>{t("Purpose")}</dt><dd class="said">{mission.purpose}</dd></>}
      {mission.notes && <><dt>{t("Notes")}</dt><dd class="said">{mission.notes}</dd></>}
      <dt>{t("Written by")}</dt><dd>{written.by}, {utc(written.time_us)}{changed && `; ${t("changed by {by}, {time}", { by: changed.by, time: utc(changed.time_us) })}`}{withdrawn && `; ${t("withdrawn by {by}, {time}", { by: withdrawn.by, time: utc(withdrawn.time_us) })}`}</dd>
    </dl>
  );
}

function Acts({ book, mission: { mission, may_change }, called }: Part) {
  const { doing, trouble } = book;
  return (
    <div class="row no-print">
      {mission.vessels.map((vessel) => <a key={vessel} class="button main" href={replayOf(mission, vessel, book.toUs())}>{t("Replay {name}", { name: called(vessel) })}</a>)}
      <button type="button" onClick={() => window.print()}>{t("Print")}</button>
      {may_change && <button type="button" onClick={() => (doing.value = "change")}>{t("Change")}</button>}
      {may_change && <button type="button" onClick={() => (doing.value = "withdraw")}>{t("Withdraw …")}</button>}
      {doing.value === "withdraw" && (
        <span class="row" role="group" aria-label={t("Withdraw this mission")}>
          {" "}{t("It is no longer listed, but kept. Recordings and notes stay.")}{" "}
          <button type="button" class="main" ref={(node) => node?.focus()} onClick={() => void book.withdraw()}>{t("Withdraw")}</button>
          <button type="button" onClick={() => (doing.value = "")}>{t("Keep")}</button>
        </span>
      )}
      {trouble.value && <span class="bad-text" role="alert">{trouble.value}</span>}
    </div>
  );
}

function Summary({ book, called }: { readonly book: Book; readonly called: Called }) {
  const { trouble, busy, value } = book.summary;
  return (
    <section>
      <h2>{t("Summary")}</h2>
      {trouble.value && <p class="bad-text" role="alert">{trouble.value} <button type="button" onClick={() => book.askSummary()}>{t("Try again")}</button></p>}
      {busy.value && <p role="status">{t("Reading the recordings …")}</p>}
      {value.value && <VesselTable vessels={value.value.vessels} called={called} />}
    </section>
  );
}

function Files({ book, mission: { mission }, called }: Part) {
  const toUs = book.toUs();
  return (
    <section class="no-print">
      <h2>{t("Files")}</h2>
      <ul class="files">
        <li><a href={missionFile("positions", mission, toUs)} download>{t("Positions, one a second (CSV)")}</a></li>
        {mission.vessels.map((vessel) => <li key={vessel}><a href={trackFile(vessel, mission.from_us, toUs, "gpx")} download>{t("Track of {vessel} (GPX)", { vessel: called(vessel) })}</a></li>)}
        {mission.vessels.map((vessel) => <li key={vessel}><a href={trackFile(vessel, mission.from_us, toUs, "nc")} download>{t("Track of {vessel} (NetCDF)", { vessel: called(vessel) })}</a></li>)}
        <li><a href={missionFile("detections", mission, toUs)} download>{t("Detections (CSV)")}</a></li>
        <li><a href={missionFile("log", mission, toUs)} download>{t("Everything, as a log (LSF)")}</a></li>
        <li><a href={`/api/v1/logbook.csv?${notesOf(mission, toUs)}`} download>{t("Log book (CSV)")}</a></li>
      </ul>
    </section>
  );
}

function Notes({ book, vessels }: { readonly book: Book; readonly vessels: readonly (readonly [number, string])[] }) {
  const { trouble, value } = book.notes;
  const again = (): void => void book.askNotes();
  return (
    <section>
      <h2>{t("Log book")}</h2>
      {trouble.value && <p class="bad-text" role="alert">{trouble.value}</p>}
      {value.value?.notes.length === 0 && <p>{t("The log book has no note of this time and these vessels.")}</p>}
      {value.value?.next && <p>{t("The newest {n} notes.", { n: value.value.notes.length })}</p>}
      <NoteList notes={value.value?.notes ?? []} vessels={vessels.map(([address, name]) => [String(address), name] as const)} changed={again} again={again} />
      <p class="no-print"><a href="/logbook">{t("Log book")}</a></p>
    </section>
  );
}

export function startMission(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["names"] ?? "{}") as Record<string, string>;
  const [writes, may] = [root.dataset["writes"] ?? "", root.dataset["researcher"] !== undefined];
  const called = (address: number): string => names[String(address)] ?? hexAddress(address);
  const book = new Book(root.dataset["id"] ?? "");
  const { one, doing, recorded } = book;
  const Page = () => {
    const mission = one.value.value;
    if (!mission) return one.trouble.value ? <p class="bad-text" role="alert">{one.trouble.value} <button type="button" onClick={() => void book.learn()}>{t("Try again")}</button></p> : <p role="status">{t("Fetching …")}</p>;
    const part = { book, mission, called };
    return (
      <>
        <h1>{mission.mission.name}</h1>
        {doing.value === "change" ? (
          <MissionForm draft={missionDraft(mission.mission)} vessels={withOwn(choosable(names, writes, recorded.value.value ?? []), mission.mission.vessels, called)} label={t("Change the mission")} send={book.change} cancel={() => (doing.value = "")} />
        ) : <><About {...part} /><Acts {...part} /></>}
        <Summary book={book} called={called} />
        {may && <Files {...part} />}
        <Notes book={book} vessels={choosable(names, writes, [])} />
      </>
    );
  };
  root.replaceChildren();
  render(<Page />, root);
  createChrome({ messages: ["VehicleState"], events: false, every_ms: 500 }, {});
  void book.learn();
  if (writes) void recorded.ask("/api/v1/recorded");
}

/** With the mission's own vessels, of which perhaps nothing is recorded. */
function withOwn(vessels: readonly (readonly [number, string])[], own: readonly number[], called: (address: number) => string): readonly (readonly [number, string])[] {
  const known = new Set(vessels.map(([address]) => address));
  return [...vessels, ...own.filter((one) => !known.has(one)).map((one) => [one, called(one)] as const)];
}

function VesselTable({ vessels, called }: { readonly vessels: readonly MissionVessel[]; readonly called: (address: number) => string }) {
  const heads = [t("Vessel"), t("First position (UTC)"), t("Last position (UTC)"), t("Distance"), t("Recorded"), t("Battery"), t("Energy"), t("Detections"), t("Tags"), t("Plans")];
  const percent = (value: number | null): string => (value === null ? "—" : `${value.toFixed(0)} %`);
  return (
    <div class="wide" tabIndex={0} role="region" aria-label={t("Summary")}>
      <table class="compact" ref={(table) => void (table && asCards(table))}>
        <thead><tr>{heads.map((head) => <th key={head} scope="col">{head}</th>)}</tr></thead>
        <tbody>
          {vessels.map((one) => (
            <tr key={one.vessel}>
              <th scope="row">{called(one.vessel)}</th>
              <td class="num" data-name={heads[1]}>{one.first_us === null ? t("none") : utc(one.first_us)}</td>
              <td class="num" data-name={heads[2]}>{one.last_us === null ? t("none") : utc(one.last_us)}</td>
              <td class="num" data-name={heads[3]}>{one.first_us === null ? "—" : distance(one.distance_m)}</td>
              <td class="num" data-name={heads[4]}>{one.first_us === null ? "—" : hoursText(one.recorded_s)}</td>
              <td class="num" data-name={heads[5]}>{one.battery_first_percent === null ? "—" : t("{from} to {to}", { from: percent(one.battery_first_percent), to: percent(one.battery_last_percent) })}</td>
              <td class="num" data-name={heads[6]}>{one.energy_wh === null ? "—" : `${count(Math.round(one.energy_wh))} Wh`}</td>
              <td class="num" data-name={heads[7]}>{count(one.detections)}</td>
              <td class="num" data-name={heads[8]}>{count(one.tags)}</td>
              <td data-name={heads[9]}>{one.plans.join(", ") || "—"}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
