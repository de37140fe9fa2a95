// The tags that all vessels heard: filter, map, times, table, and one file of exactly what is filtered.

import { computed, signal } from "@preact/signals";
import { render } from "preact";
import type { Detection, Detections, Recorded, RegisterAnswer } from "../api/types.gen";
import { look, lookedBackTo } from "../api/looking";
import { resource } from "../api/resource";
import { HeardMap } from "../components/heardmap";
import { Spans, TimeSpan } from "../components/timespan";
import { keptHiddenTags, TagLegend } from "../components/taglegend";
import { Times, timesOf } from "../components/times";
import { flagReason } from "../state/flags";
import { detectionCompleted } from "../state/newest";
import { calledBy, FORMATS, tagNames } from "../state/register";
import { countsOf, tagSeries } from "../state/tags";
import { pickedUs, spanWrong } from "../state/takeout";
import { createChrome } from "../ui/chrome";
import { hexAddress, position, receiverName, tagName, utc } from "../ui/format";
import { t, tn } from "../words/words";

/** Rows that are shown at first, and more with each asking. */
const PAGE = 500;
const LAST_US = 9_007_199_254_740_991;

/** What the page knows: the filter, what it found, and what of that is shown. */
class Heard {
  readonly from = signal("");
  readonly to = signal("");
  readonly tags = signal("");
  readonly vessel = signal("");
  readonly answer = resource<Detections>();
  readonly rows = signal<readonly Detection[]>([]);
  readonly asked = signal("");
  readonly more = signal("");
  readonly register = resource<RegisterAnswer>();
  readonly names = computed(() => tagNames(this.register.value.value?.entries ?? []));
  readonly format = signal("lutra");
  /** Tags that are left out of map, times and table, by their names. */
  readonly hidden = keptHiddenTags();
  /** Those of a place on the map that was chosen; undefined for all. */
  readonly picked = signal<ReadonlySet<string> | undefined>(undefined);
  readonly groups = computed(() => timesOf(this.rows.value));
  readonly counts = computed(() => countsOf(this.rows.value));
  readonly shown = computed(() => this.rows.value.filter((one) => !this.hidden.value.has(tagName(one))));
  readonly listed = computed(() => this.shown.value.filter((one) => !this.picked.value || this.picked.value.has(keyOf(one))));
  readonly wrong = computed(() => spanWrong(this.from.value, this.to.value)?.text ?? "");
  readonly tagWrong = computed(() => /^tag: (.*)$/s.exec(this.answer.trouble.value)?.[1] ?? "");

  private query(): string {
    const [from, to] = [this.from.value, this.to.value];
    const wanted = new URLSearchParams({ from_us: String(from ? pickedUs(from) : 0), to_us: String(to ? pickedUs(to) : LAST_US) });
    const list = this.tags.value.split(/[\s,]+/).filter(Boolean).join(",");
    if (list) wanted.set("tag", list);
    if (this.vessel.value) wanted.set("vessel", this.vessel.value);
    return wanted.toString();
  }

  /** Whether the rows are those of another filter, for the question of this one failed. */
  readonly before = signal(false);

  readonly show = async (): Promise<void> => {
    if (this.wrong.value) return;
    const wanted = this.query();
    this.before.value = wanted !== this.asked.value;
    const found = await look(this.answer, `${wanted}&order=newest&limit=${PAGE}&flags=true`, 1, this.far);
    this.lookedTo.value = 0;
    if (!found) return;
    [this.rows.value, this.asked.value, this.picked.value, this.before.value] = [found.rows, wanted, undefined, false];
    this.more.value = found.rest;
  };

  /** How far back the search has come without finding any, µs; 0 before it is reported. */
  readonly lookedTo = signal(0);

  private readonly far = ({ rest }: { readonly rest: string }): void => { this.lookedTo.value = lookedBackTo(rest); };

  readonly older = async (): Promise<void> => {
    const found = await look(this.answer, this.more.value, 1, this.far);
    this.lookedTo.value = 0;
    if (!found) return;
    this.rows.value = joined(this.rows.value, found.rows);
    this.more.value = found.rest;
  };

  /** What came by itself. */
  take(detections: readonly Detection[]): void {
    const fresh = detections.filter((one) => isWanted(one, this.asked.value));
    if (fresh.length) this.rows.value = joined(this.rows.value, fresh);
  }
}

type Called = (address: number) => string;

function Filters({ heard, vessels, called }: { readonly heard: Heard; readonly vessels: readonly number[]; readonly called: Called }) {
  const { from, to, tags, vessel, wrong, tagWrong, show } = heard;
  return (
    <form class="filters" aria-label={t("Filter")} onSubmit={(event) => { event.preventDefault(); void show(); }}>
      <TimeSpan from={from} to={to} toWrong={wrong.value} />
      <div class="field">
        <label for="tags">{t("Tags")}</label>
        <input id="tags" value={tags.value} placeholder="S256-101, 102" autocomplete="off" aria-invalid={tagWrong.value !== ""} aria-describedby="tags-wrong" onInput={(event) => (tags.value = event.currentTarget.value)} />
        <p id="tags-wrong" class="wrong" role="alert">{tagWrong.value}</p>
      </div>
      <label>{t("Vessel")}<select value={vessel.value} onChange={(event) => (vessel.value = event.currentTarget.value)}><option value="">{t("All vessels")}</option>{vessels.map((address) => <option key={address} value={String(address)}>{called(address)}</option>)}</select></label>
      <button class="main">{t("Show")}</button>
      <Spans from={from} to={to} then={() => void show()} />
    </form>
  );
}

/** Map, times and table of what was found. */
function Found({ heard, called }: { readonly heard: Heard; readonly called: Called }) {
  const { shown, asked, picked, counts, hidden, groups, listed } = heard;
  return (
    <>
      <div class="heard">
        <HeardMap detections={shown.value} whole={asked.value} pick={(group) => (picked.value = new Set(group.map(keyOf)))} />
        <section aria-label={t("Tags")}>
          <TagLegend tags={counts.value} hidden={hidden} />
          <Times groups={groups.value.filter(({ tag }) => !hidden.value.has(tag))} />
        </section>
      </div>
      {picked.value && <p class="row">{tn(listed.value.length, "{n} detection at the place on the map.", "{n} detections at the place on the map.")}{" "}<button type="button" onClick={() => (picked.value = undefined)}>{t("Show all")}</button></p>}
      <Table rows={listed.value} called={called} registered={(one) => calledBy(heard.names.value, one)} />
    </>
  );
}

/** How many were found, and the way to take them away for who `may`. */
function Count({ heard: { answer, before, more, rows, asked, tagWrong, format, lookedTo }, may }: { readonly heard: Heard; readonly may: boolean }) {
  const n = rows.value.length;
  const [busy, trouble] = [answer.busy.value, answer.trouble.value];
  // What failed says nothing of how many there are: what was found before stays, and is said to be that.
  const count = more.value ? tn(n, "1 newest detection.", "{n} newest detections.") : tn(n, "1 detection.", "{n} detections.");
  const old = tn(n, "Below is the 1 detection of the filter before.", "Below are the {n} detections of the filter before.");
  const told = trouble && !n ? "" : trouble && before.value ? old : count;
  return (
    <>
      {trouble && !tagWrong.value && <p class="bad-text" role="alert">{trouble}</p>}
      <p role="status">{lookedTo.value > 0 ? t("Still looking: back to {time} so far.", { time: utc(lookedTo.value) }) : busy ? t("Fetching …") : told}</p>
      {may && asked.value && n > 0 && <p class="row"><label class="inline">{t("Format")} <select value={format.value} onChange={(event) => (format.value = event.currentTarget.value)}>{FORMATS.map(([name, about]) => <option key={name} value={name}>{about}</option>)}</select></label><a class="button" href={`/api/v1/detections.csv?${asked.value}${format.value === "lutra" ? "" : `&format=${format.value}`}`} download>{t("Download all detections of this filter")}</a></p>}
      {n === 0 && !busy && !trouble && more.value && <p>{t("No tag was found back to {time}. Look at older detections, or choose a time.", { time: utc(lookedBackTo(more.value)) })}</p>}
      {n === 0 && !busy && !trouble && !more.value && <p>{t("No tag was heard in this time. Choose a longer time, or clear the tag filter.")}</p>}
    </>
  );
}

export function startDetections(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["names"] ?? "{}") as Record<string, string>;
  const may = root.dataset["researcher"] !== undefined;
  const called = (address: number): string => names[String(address)] ?? hexAddress(address);
  const [heard, recorded] = [new Heard(), resource<Recorded[]>()];
  const vessels = computed(() => [...new Set([...Object.keys(names).map(Number), ...(recorded.value.value ?? []).map(({ system }) => system)])]);
  const Page = () => (
    <>
      <Filters heard={heard} vessels={vessels.value} called={called} />
      <Count heard={heard} may={may} />
      {heard.rows.value.length > 0 && <Found heard={heard} called={called} />}
      {heard.more.value && <button type="button" onClick={() => void heard.older()}>{t("Older detections")}</button>}
    </>
  );
  let begun = false;
  render(<Page />, root);
  createChrome({ messages: ["VehicleState", "TBRFishTag", "Event"], events: true, every_ms: 500 }, {
    frame: (_, { detections, snapshot, events_missed }) => {
      // What came ashore while nothing came by itself is asked for.
      if ((snapshot || events_missed) && begun) void heard.show();
      begun = true;
      heard.take(detections);
    },
  });
  void recorded.ask("/api/v1/recorded");
  void heard.register.ask("/api/v1/register?kind=tag");
  void heard.show();
}

function Table({ rows, called, registered }: { readonly rows: readonly Detection[]; readonly called: Called; registered(one: Detection): string }) {
  const heads = [t("Heard (UTC)"), t("Tag"), t("Registered as"), t("Vessel"), t("Receiver"), t("SNR (dB)"), t("Sensor (count)"), t("Place of the vessel"), t("Clock"), t("Check")];
  return (
    <div class="wide" tabIndex={0} role="region" aria-label={t("Detections")}>
      <table class="compact lines" role="table">
        <thead role="rowgroup"><tr role="row">{heads.map((head) => <th key={head} scope="col" role="columnheader">{head}</th>)}</tr></thead>
        <tbody role="rowgroup">
          {rows.map((one) => (
            <tr key={keyOf(one)} role="row">
              <td role="cell" class="num">{one.heard_us === null ? t("{time} (reported)", { time: utc(one.time_us) }) : new Date(one.heard_us / 1_000).toISOString().replace("T", " ")}</td>
              <td role="cell" data-tag={tagSeries(one.tag_id)}>{tagName(one)}</td><td role="cell">{registered(one)}</td><td role="cell" class="whole">{called(one.system)}</td><td role="cell" data-name={heads[4]}>{receiverName(one)}</td><td role="cell" data-name={heads[5]}>{one.snr_db ?? ""}</td><td role="cell" data-name={heads[6]}>{one.data ?? ""}</td>
              <td role="cell" class="whole">{one.lat_deg === null || one.lon_deg === null ? t("not known") : position({ lat_deg: one.lat_deg, lon_deg: one.lon_deg })}</td>
              <td role="cell" data-name={heads[8]}>{clockWord(one.clock)}</td>
              <td role="cell" class="text">{one.flags?.map((flag) => flagReason(flag)).join(" ") ?? t("not known")}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

/** What is known of the receiver's clock. */
function clockWord(clock: Detection["clock"]): string {
  switch (clock) {
    case "not_set": return t("not set");
    case "lost": return t("was lost");
    case "set": return t("set");
    case "disciplined": return t("set and kept");
  }
}

/** What tells detections apart. */
function keyOf({ system, id }: Detection): string {
  return `${system}/${id}`;
}

/** Each once, with all that its reports tell, the newest report first. */
function joined(before: readonly Detection[], next: readonly Detection[]): readonly Detection[] {
  const all = new Map(before.map((one) => [keyOf(one), one]));
  for (const one of next) {
    const key = keyOf(one);
    const known = all.get(key);
    all.set(key, known ? detectionCompleted(known, one) : one);
  }
  return [...all.values()].sort((one, other) => other.time_us - one.time_us);
}

/** Whether a detection that came by itself is one of those that are shown. */
function isWanted(one: Detection, asked: string): boolean {
  const query = new URLSearchParams(asked);
  const [tag, vessel] = [query.get("tag"), query.get("vessel")];
  const isTag = (name: string): boolean => name.toLowerCase() === tagName(one).toLowerCase() || name === String(one.tag_id);
  return asked !== "" && one.time_us >= Number(query.get("from_us")) && one.time_us < Number(query.get("to_us")) && (!tag || tag.split(",").some(isTag)) && (!vessel || vessel === String(one.system));
}
