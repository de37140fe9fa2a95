// The missions: a list, and the form of a new one.

import { signal } from "@preact/signals";
import { render } from "preact";
import { postJson, reason } from "../api/http";
import type { Mission, Missions, Recorded } from "../api/types.gen";
import { resource } from "../api/resource";
import { MissionForm } from "../components/missionform";
import { type MissionDraft, missionAsk, newDraft } from "../state/missions";
import { fieldOf, type Wrong } from "../state/notes";
import { createChrome } from "../ui/chrome";
import { hexAddress, utc } from "../ui/format";

const PATIENCE_MS = 15_000;

/** Vessels that somebody may choose: those with a name, and those of which something is recorded. */
export function choosable(names: Readonly<Record<string, string>>, writes: string, recorded: readonly Recorded[]): readonly (readonly [number, string])[] {
  const all = new Set([...Object.keys(names).map(Number), ...recorded.map(({ system }) => system)]);
  const may = (address: number): boolean => writes === "all" || writes.split(",").includes(String(address));
  return [...all].filter(may).map((address) => [address, names[String(address)] ?? hexAddress(address)] as const);
}

export function startMissions(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["names"] ?? "{}") as Record<string, string>;
  const writes = root.dataset["writes"] ?? "";
  const called = (address: number): string => names[String(address)] ?? hexAddress(address);
  const [page, recorded] = [resource<Missions>(), resource<Recorded[]>()];
  const missions = signal<readonly Mission[]>([]);
  const next = signal<string | null>(null);
  const writing = signal(false);
  const withdrawn = signal(false);
  const show = async (before: string | null = null): Promise<void> => {
    const query = new URLSearchParams({ ...(withdrawn.value ? { withdrawn: "true" } : {}), ...(before ? { before } : {}) });
    const found = await page.ask(`/api/v1/missions?${query}`);
    if (found) [missions.value, next.value] = [before ? [...missions.value, ...found.missions] : found.missions, found.next];
  };
  const create = async (draft: MissionDraft): Promise<Wrong | undefined> => {
    try {
      const made = await postJson<Mission>("/api/v1/missions", PATIENCE_MS, missionAsk(draft));
      location.assign(`/missions/${made.id}`);
      return undefined;
    } catch (error) {
      return fieldOf(reason(error));
    }
  };
  const Table = () => (
    <div class="wide" tabIndex={0} role="region" aria-label="Missions">
      <table class="compact">
        <thead><tr>{["Mission", "From (UTC)", "To (UTC)", "Vessels", "People", "Purpose"].map((head) => <th key={head} scope="col">{head}</th>)}</tr></thead>
        <tbody>
          {missions.value.map(({ id, mission, withdrawn }) => (
            <tr key={id}>
              <th scope="row"><a href={`/missions/${id}`}>{mission.name}</a>{withdrawn && " (withdrawn)"}</th>
              <td class="num">{utc(mission.from_us)}</td>
              <td class="num">{mission.to_us === null ? "goes on" : utc(mission.to_us)}</td>
              <td>{mission.vessels.map(called).join(", ")}</td>
              <td>{mission.people}</td>
              <td>{mission.purpose}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
  const Page = () => (
    <>
      {writes && (writing.value ? (
        <section><h2>New mission</h2><MissionForm draft={newDraft(Date.now())} vessels={choosable(names, writes, recorded.value.value ?? [])} label="New mission" send={create} cancel={() => (writing.value = false)} /></section>
      ) : <p><button type="button" class="main" onClick={() => (writing.value = true)}>New mission</button></p>)}
      {page.trouble.value && <p class="bad-text" role="alert">{page.trouble.value} <button type="button" onClick={() => void show()}>Try again</button></p>}
      {missions.value.length > 0 && <Table />}
      {missions.value.length === 0 && page.value.value && <p>{writes ? "No mission is written down yet. Make one by New mission: its replay, files, notes and summary are then in one place." : "No mission is written down yet. Operators do that."}</p>}
      {next.value && <button type="button" onClick={() => void show(next.value)}>Older missions</button>}
      <p><label class="inline"><input type="checkbox" checked={withdrawn.value} onChange={(event) => { withdrawn.value = event.currentTarget.checked; void show(); }} />Withdrawn too</label></p>
    </>
  );
  root.replaceChildren();
  render(<Page />, root);
  createChrome({ messages: ["VehicleState"], events: false, every_ms: 500 }, {});
  void show();
  if (writes) void recorded.ask("/api/v1/recorded");
}
