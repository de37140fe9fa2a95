// The missions: a list, which follows what others do, and the form of a new one.

import { signal } from "@preact/signals";
import { render } from "preact";
import { getJson, inEnglish, reason } from "../api/http";
import type { Mission, Missions, Recorded } from "../api/types.gen";
import { resource } from "../api/resource";
import { postUntilAnswered } from "../api/retry";
import { MissionForm } from "../components/missionform";
import { MissionTable } from "../components/missiontable";
import { knownVessels } from "../state/known";
import { type MissionDraft, missionAsk, newDraft, withNewestMissions } from "../state/missions";
import { fieldOf, type Wrong } from "../state/notes";
import { Keys } from "../state/sending";
import { newKey } from "../state/window";
import { createChrome } from "../ui/chrome";
import { hexAddress } from "../ui/format";
import { t } from "../words/words";

const PATIENCE_MS = 15_000;
/** For so long a mission that nobody answers is sent again by itself, ms. */
const SENT_WITHIN_MS = 120_000;
/** What others did comes after so long at most, ms. */
const AGAIN_MS = 20_000;

/** Vessels that a person may choose who may write about these. */
export function choosable(names: Readonly<Record<string, string>>, writes: string, recorded: readonly Recorded[]): readonly (readonly [number, string])[] {
  const may = (address: number): boolean => writes === "all" || writes.split(",").includes(String(address));
  return knownVessels(names, recorded).filter(may).map((address) => [address, names[String(address)] ?? hexAddress(address)] as const);
}

/** What the page knows of missions. */
class List {
  readonly page = resource<Missions>();
  readonly missions = signal<readonly Mission[]>([]);
  readonly next = signal<string | null>(null);
  readonly withdrawn = signal(false);

  async show(before: string | null = null): Promise<void> {
    const found = await this.page.ask(this.question(before));
    if (found) [this.missions.value, this.next.value] = [before ? [...this.missions.value, ...found.missions] : found.missions, found.next];
  }

  /** What others did comes by itself; who asks for something meanwhile goes first. */
  async again(): Promise<void> {
    const { busy } = this.page;
    const of = this.withdrawn.value;
    if (document.hidden || busy.value) return;
    const found = await getJson<Missions>(this.question(null), AbortSignal.timeout(PATIENCE_MS)).catch(() => undefined);
    if (!found || this.withdrawn.value !== of || busy.value) return;
    const all = withNewestMissions(this.missions.value, found);
    if (all.length === found.missions.length) this.next.value = found.next;
    this.missions.value = all;
  }

  private question(before: string | null): string {
    const query = new URLSearchParams({ ...(this.withdrawn.value ? { withdrawn: "true" } : {}), ...(before ? { before } : {}) });
    return `/api/v1/missions?${query}`;
  }
}

const keys = new Keys<MissionDraft>(newKey);

async function create(draft: MissionDraft, waits: (tries: number) => void): Promise<Wrong | undefined> {
  try {
    const query = new URLSearchParams({ key: keys.of(draft).key });
    const made = await postUntilAnswered<Mission>(() => `/api/v1/missions?${query}`, PATIENCE_MS, SENT_WITHIN_MS, missionAsk(draft), waits);
    keys.answered();
    location.assign(`/missions/${made.id}`);
    return undefined;
  } catch (error) {
    return fieldOf(reason(error), inEnglish(error));
  }
}

export function startMissions(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["names"] ?? "{}") as Record<string, string>;
  const writes = root.dataset["writes"] ?? "";
  const called = (address: number): string => names[String(address)] ?? hexAddress(address);
  const [list, recorded, writing] = [new List(), resource<Recorded[]>(), signal(false)];
  const { page, missions, next, withdrawn } = list;
  const Page = () => (
    <>
      {writes && (writing.value ? (
        <section><h2>{t("New mission")}</h2><MissionForm draft={newDraft(Date.now())} vessels={choosable(names, writes, recorded.value.value ?? [])} label={t("New mission")} send={create} cancel={() => (writing.value = false)} /></section>
      ) : <p><button type="button" class="main" onClick={() => (writing.value = true)}>{t("New mission")}</button></p>)}
      {page.trouble.value && <p class="bad-text" role="alert">{page.trouble.value} <button type="button" onClick={() => void list.show()}>{t("Try again")}</button></p>}
      {missions.value.length > 0 && <MissionTable missions={missions.value} called={called} />}
      {missions.value.length === 0 && page.value.value && <p>{writes ? t("No missions yet. Press New mission to add one: its replay, files, notes and summary are then in one place.") : t("No missions yet. Operators add them.")}</p>}
      {next.value && <button type="button" onClick={() => void list.show(next.value)}>{t("Older missions")}</button>}
      <p><label class="inline"><input type="checkbox" checked={withdrawn.value} onChange={(event) => { withdrawn.value = event.currentTarget.checked; void list.show(); }} />{t("Show withdrawn")}</label></p>
    </>
  );
  root.replaceChildren();
  render(<Page />, root);
  createChrome({ messages: ["VehicleState"], events: false, every_ms: 500 }, {});
  void list.show();
  window.setInterval(() => void list.again(), AGAIN_MS);
  if (writes) void recorded.ask("/api/v1/recorded");
}
