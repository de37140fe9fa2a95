// One mission: what it was, its replay, its summary, its files and its notes; to be printed.

import { signal } from "@preact/signals";
import { render } from "preact";
import { deleteAt, patchJson, reason } from "../api/http";
import type { LogNotes, Mission, MissionChange, MissionSummary, MissionVessel, Recorded } from "../api/types.gen";
import { resource } from "../api/resource";
import { MissionForm } from "../components/missionform";
import { NoteList } from "../components/notelist";
import { hoursText, type MissionDraft, missionAsk, missionDraft, missionFile, notesOf, replayOf } from "../state/missions";
import { fieldOf, type Wrong } from "../state/notes";
import { createChrome } from "../ui/chrome";
import { distance, hexAddress, utc } from "../ui/format";
import { choosable } from "./missions";

const PATIENCE_MS = 15_000;
/** A summary reads through the whole mission. */
const SUMMARY_PATIENCE_MS = 180_000;

export function startMission(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["names"] ?? "{}") as Record<string, string>;
  const [id, writes, may] = [root.dataset["id"] ?? "", root.dataset["writes"] ?? "", root.dataset["researcher"] !== undefined];
  const called = (address: number): string => names[String(address)] ?? hexAddress(address);
  const [one, summary, notes] = [resource<Mission>(), resource<MissionSummary>(SUMMARY_PATIENCE_MS), resource<LogNotes>()];
  const recorded = resource<Recorded[]>();
  const doing = signal<"" | "change" | "withdraw">("");
  const trouble = signal("");
  const path = `/api/v1/missions/${id}`;
  const toUs = (): number => one.value.value?.mission.to_us ?? Math.max(Date.now() * 1_000, (one.value.value?.mission.from_us ?? 0) + 1);
  const askNotes = async (): Promise<void> => {
    if (one.value.value) await notes.ask(`/api/v1/logbook?${notesOf(one.value.value.mission, toUs())}&limit=500`);
  };
  const learn = async (): Promise<void> => {
    if (!(await one.ask(path))) return;
    void askNotes();
    void summary.ask(`${path}/summary`);
  };
  const change = async (draft: MissionDraft): Promise<Wrong | undefined> => {
    const mission = one.value.value;
    if (!mission) return undefined;
    try {
      const asked = missionAsk(draft);
      // A picker knows whole seconds: what was not touched stays as it is.
      const before = missionDraft(mission.mission);
      const exact = { ...asked, from_us: draft.from === before.from ? mission.mission.from_us : asked.from_us, to_us: draft.to === before.to ? mission.mission.to_us : asked.to_us };
      await patchJson<Mission>(path, { revision: mission.revision, mission: exact } satisfies MissionChange, PATIENCE_MS);
      doing.value = "";
      document.title = `${exact.name} · Lutra`;
      void learn();
      return undefined;
    } catch (error) {
      return fieldOf(reason(error));
    }
  };
  const withdraw = async (): Promise<void> => {
    try {
      await deleteAt(path, PATIENCE_MS);
      location.assign("/missions");
    } catch (error) {
      trouble.value = reason(error);
    }
  };

  const About = ({ mission, written, changed, withdrawn }: Mission) => (
    <dl class="mission-about">
      <dt>Time (UTC)</dt><dd class="num">{utc(mission.from_us)} to {mission.to_us === null ? "now: it goes on" : utc(mission.to_us)}</dd>
      <dt>Vessels</dt><dd>{mission.vessels.map(called).join(", ")}</dd>
      {mission.people && <><dt>People</dt><dd>{mission.people}</dd></>}
      {mission.purpose && <><dt>Purpose</dt><dd class="said">{mission.purpose}</dd></>}
      {mission.notes && <><dt>Notes</dt><dd class="said">{mission.notes}</dd></>}
      <dt>Written by</dt><dd>{written.by}, {utc(written.time_us)}{changed && `; changed by ${changed.by}, ${utc(changed.time_us)}`}{withdrawn && `; withdrawn by ${withdrawn.by}, ${utc(withdrawn.time_us)}`}</dd>
    </dl>
  );
  const Acts = ({ mission, may_change }: Mission) => (
    <div class="row no-print">
      {mission.vessels.map((vessel) => <a key={vessel} class="button main" href={replayOf(mission, vessel, toUs())}>Replay {called(vessel)}</a>)}
      <button type="button" onClick={() => window.print()}>Print</button>
      {may_change && <button type="button" onClick={() => (doing.value = "change")}>Change</button>}
      {may_change && <button type="button" onClick={() => (doing.value = "withdraw")}>Withdraw …</button>}
      {doing.value === "withdraw" && (
        <span class="row" role="group" aria-label="Withdraw this mission">
          It is not listed any more, and is kept. Recordings and notes stay.
          <button type="button" class="main" ref={(node) => node?.focus()} onClick={() => void withdraw()}>Withdraw</button>
          <button type="button" onClick={() => (doing.value = "")}>Keep</button>
        </span>
      )}
      {trouble.value && <span class="bad-text" role="alert">{trouble.value}</span>}
    </div>
  );
  const Summary = () => (
    <section>
      <h2>Summary</h2>
      {summary.trouble.value && <p class="bad-text" role="alert">{summary.trouble.value} <button type="button" onClick={() => void summary.ask(`${path}/summary`)}>Try again</button></p>}
      {summary.busy.value && <p role="status">Reading the recordings …</p>}
      {summary.value.value && <VesselTable vessels={summary.value.value.vessels} called={called} />}
    </section>
  );
  const Files = ({ mission }: Mission) => (
    <section class="no-print">
      <h2>Files</h2>
      <ul class="files">
        <li><a href={missionFile("positions", mission, toUs())} download>Positions, one a second (CSV)</a></li>
        <li><a href={missionFile("detections", mission, toUs())} download>Detections (CSV)</a></li>
        <li><a href={missionFile("log", mission, toUs())} download>Everything, as a log (LSF)</a></li>
        <li><a href={`/api/v1/logbook.csv?${notesOf(mission, toUs())}`} download>Log book (CSV)</a></li>
      </ul>
    </section>
  );
  const Notes = () => (
    <section>
      <h2>Log book</h2>
      {notes.trouble.value && <p class="bad-text" role="alert">{notes.trouble.value}</p>}
      {notes.value.value?.notes.length === 0 && <p>The log book has no note of this time and these vessels.</p>}
      {notes.value.value?.next && <p>The newest {notes.value.value.notes.length} notes.</p>}
      <NoteList notes={notes.value.value?.notes ?? []} vessels={choosable(names, writes, []).map(([address, name]) => [String(address), name] as const)} changed={() => void askNotes()} again={() => void askNotes()} />
      <p class="no-print"><a href="/logbook">Log book</a></p>
    </section>
  );
  const Page = () => {
    const mission = one.value.value;
    if (!mission) return one.trouble.value ? <p class="bad-text" role="alert">{one.trouble.value} <button type="button" onClick={() => void learn()}>Try again</button></p> : <p role="status">Fetching …</p>;
    return (
      <>
        <h1>{mission.mission.name}</h1>
        {doing.value === "change" ? (
          <MissionForm draft={missionDraft(mission.mission)} vessels={withOwn(choosable(names, writes, recorded.value.value ?? []), mission.mission.vessels, called)} label="Change the mission" send={change} cancel={() => (doing.value = "")} />
        ) : <><About {...mission} /><Acts {...mission} /></>}
        <Summary />
        {may && <Files {...mission} />}
        <Notes />
      </>
    );
  };
  root.replaceChildren();
  render(<Page />, root);
  createChrome({ messages: ["VehicleState"], events: false, every_ms: 500 }, {});
  void learn();
  if (writes) void recorded.ask("/api/v1/recorded");
}

/** With the mission's own vessels, of which perhaps nothing is recorded. */
function withOwn(vessels: readonly (readonly [number, string])[], own: readonly number[], called: (address: number) => string): readonly (readonly [number, string])[] {
  const known = new Set(vessels.map(([address]) => address));
  return [...vessels, ...own.filter((one) => !known.has(one)).map((one) => [one, called(one)] as const)];
}

function VesselTable({ vessels, called }: { readonly vessels: readonly MissionVessel[]; readonly called: (address: number) => string }) {
  const heads = ["Vessel", "First position (UTC)", "Last position (UTC)", "Distance", "Recorded", "Battery", "Detections", "Tags"];
  const percent = (value: number | null): string => (value === null ? "—" : `${value.toFixed(0)} %`);
  return (
    <div class="wide" tabIndex={0} role="region" aria-label="Summary">
      <table class="compact">
        <thead><tr>{heads.map((head) => <th key={head} scope="col">{head}</th>)}</tr></thead>
        <tbody>
          {vessels.map((one) => (
            <tr key={one.vessel}>
              <th scope="row">{called(one.vessel)}</th>
              <td class="num">{one.first_us === null ? "none" : utc(one.first_us)}</td>
              <td class="num">{one.last_us === null ? "none" : utc(one.last_us)}</td>
              <td class="num">{one.first_us === null ? "—" : distance(one.distance_m)}</td>
              <td class="num">{one.first_us === null ? "—" : hoursText(one.recorded_s)}</td>
              <td class="num">{one.battery_first_percent === null ? "—" : `${percent(one.battery_first_percent)} to ${percent(one.battery_last_percent)}`}</td>
              <td class="num">{one.detections.toLocaleString("en")}</td>
              <td class="num">{one.tags.toLocaleString("en")}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
