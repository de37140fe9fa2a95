// The tags that all vessels heard: filter, map, times, table, and one file of exactly what is filtered.

import { computed, signal } from "@preact/signals";
import { render } from "preact";
import type { Detection, Detections, Recorded } from "../api/types.gen";
import { resource } from "../api/resource";
import { HeardMap } from "../components/heardmap";
import { Spans, TimeSpan } from "../components/timespan";
import { tagColour, Times, timesOf } from "../components/times";
import { completed } from "../state/newest";
import { pickedUs } from "../state/takeout";
import { createChrome } from "../ui/chrome";
import { hexAddress, position, tagName, utc } from "../ui/format";

/** Rows that are shown at first, and more with each asking. */
const PAGE = 500;
const LAST_US = 9_007_199_254_740_991;

export function startDetections(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["names"] ?? "{}") as Record<string, string>;
  const may = root.dataset["researcher"] !== undefined;
  const [from, to, tags, vessel] = [signal(""), signal(""), signal(""), signal("")];
  const answer = resource<Detections>();
  const rows = signal<readonly Detection[]>([]);
  const asked = signal("");
  const more = signal("");
  /** Tags that are left out of map, times and table, by their names. */
  const hidden = signal<ReadonlySet<string>>(new Set());
  /** Those of a place on the map that was chosen; undefined for all. */
  const picked = signal<ReadonlySet<string> | undefined>(undefined);
  const groups = computed(() => timesOf(rows.value));
  const shown = computed(() => rows.value.filter((one) => !hidden.value.has(tagName(one))));
  const listed = computed(() => shown.value.filter((one) => !picked.value || picked.value.has(keyOf(one))));
  const toggle = (tag: string): void => {
    const next = new Set(hidden.value);
    if (!next.delete(tag)) next.add(tag);
    hidden.value = next;
  };
  const wrong = computed(() => (from.value && to.value && pickedUs(to.value) < pickedUs(from.value) ? "The end is before the beginning." : ""));
  const tagWrong = computed(() => /^tag: (.*)$/s.exec(answer.trouble.value)?.[1] ?? "");
  const query = computed(() => {
    const wanted = new URLSearchParams({ from_us: String(from.value ? pickedUs(from.value) : 0), to_us: String(to.value ? pickedUs(to.value) : LAST_US) });
    const list = tags.value.split(/[\s,]+/).filter(Boolean).join(",");
    if (list) wanted.set("tag", list);
    if (vessel.value) wanted.set("vessel", vessel.value);
    return wanted.toString();
  });
  const show = async (): Promise<void> => {
    if (wrong.value) return;
    const wanted = query.value;
    const found = await answer.ask(`/api/v1/detections?${wanted}&order=newest&limit=${PAGE}`);
    if (!found) return;
    [rows.value, asked.value, picked.value] = [found.detections, wanted, undefined];
    more.value = olderOf(found, wanted);
  };
  const older = async (): Promise<void> => {
    const found = await answer.ask(`/api/v1/detections?${more.value}`);
    if (!found) return;
    rows.value = joined(rows.value, found.detections);
    more.value = olderOf(found, asked.value);
  };
  const called = (address: number): string => names[String(address)] ?? hexAddress(address);
  const recorded = resource<Recorded[]>();
  const vessels = computed(() => [...new Set([...Object.keys(names).map(Number), ...(recorded.value.value ?? []).map(({ system }) => system)])]);
  const Page = () => (
    <>
      <form class="filters" aria-label="Filter" onSubmit={(event) => { event.preventDefault(); void show(); }}>
        <TimeSpan from={from} to={to} toWrong={wrong.value} />
        <div class="field">
          <label for="tags">Tags</label>
          <input id="tags" value={tags.value} placeholder="S256-101, 102" autocomplete="off" aria-invalid={tagWrong.value !== ""} aria-describedby="tags-wrong" onInput={(event) => (tags.value = event.currentTarget.value)} />
          <p id="tags-wrong" class="wrong" role="alert">{tagWrong.value}</p>
        </div>
        <label>Vessel<select value={vessel.value} onChange={(event) => (vessel.value = event.currentTarget.value)}><option value="">All vessels</option>{vessels.value.map((address) => <option key={address} value={String(address)}>{called(address)}</option>)}</select></label>
        <button class="main">Show</button>
        <Spans from={from} to={to} then={() => void show()} />
      </form>
      {answer.trouble.value && !tagWrong.value && <p class="bad-text" role="alert">{answer.trouble.value}</p>}
      <p role="status">{answer.busy.value ? "Fetching …" : `${rows.value.length}${more.value ? " newest" : ""} detections.`}</p>
      {may && asked.value && rows.value.length > 0 && <p><a class="button" href={`/api/v1/detections.csv?${asked.value}`} download>Download CSV of all detections of this filter</a></p>}
      {rows.value.length === 0 && !answer.busy.value && <p>No tag was heard in this time. Choose a longer time, or clear the tag filter.</p>}
      {rows.value.length > 0 && (
        <>
          <div class="heard">
            <HeardMap detections={shown.value} whole={asked.value} pick={(group) => (picked.value = new Set(group.map(keyOf)))} />
            <section aria-label="Tags">
              <ul class="legend-tags">
                {groups.value.map(({ tag, id, all }) => (
                  <li key={tag}><label class="inline"><input type="checkbox" checked={!hidden.value.has(tag)} onChange={() => toggle(tag)} /><span data-tag={tagColour(id)}>{tag}</span> <span class="dim num">{all.length}</span></label></li>
                ))}
              </ul>
              <Times groups={groups.value.filter(({ tag }) => !hidden.value.has(tag))} />
            </section>
          </div>
          {picked.value && <p class="row">{listed.value.length} detections at the place on the map. <button type="button" onClick={() => (picked.value = undefined)}>Show all</button></p>}
          <Table rows={listed.value} called={called} />
        </>
      )}
      {more.value && <button type="button" onClick={() => void older()}>Older detections</button>}
    </>
  );
  let begun = false;
  render(<Page />, root);
  createChrome({ messages: ["VehicleState", "TBRFishTag", "Event"], events: true, every_ms: 500 }, {
    frame: (_, { detections, snapshot, events_missed }) => {
      // What came ashore while nothing came by itself is asked for.
      if ((snapshot || events_missed) && begun) void show();
      begun = true;
      const fresh = detections.filter((one) => isWanted(one, asked.value));
      if (fresh.length) rows.value = joined(rows.value, fresh);
    },
  });
  void recorded.ask("/api/v1/recorded");
  void show();
}

function Table({ rows, called }: { rows: readonly Detection[]; called: (address: number) => string }) {
  const heads = ["Heard (UTC)", "Tag", "Vessel", "Receiver", "SNR (dB)", "Sensor (count)", "Place of the vessel", "Clock"];
  return (
    <div class="wide" tabIndex={0} role="region" aria-label="Detections">
      <table class="compact">
        <thead><tr>{heads.map((head) => <th key={head} scope="col">{head}</th>)}</tr></thead>
        <tbody>
          {rows.map((one) => (
            <tr key={keyOf(one)}>
              <td class="num">{one.heard_us === null ? `${utc(one.time_us)} (reported)` : new Date(one.heard_us / 1_000).toISOString().replace("T", " ")}</td>
              <td data-tag={tagColour(one.tag_id)}>{tagName(one)}</td><td>{called(one.system)}</td><td>{one.serial_no}</td><td>{one.snr_db}</td><td>{one.data ?? ""}</td>
              <td>{one.lat_deg === null || one.lon_deg === null ? "not known" : position({ lat_deg: one.lat_deg, lon_deg: one.lon_deg })}</td>
              <td>{one.clock === "set" ? "set" : "not set"}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

/** What tells detections apart. */
function keyOf({ system, id }: Detection): string {
  return `${system}/${id}`;
}

function olderOf({ next }: Detections, asked: string): string {
  if (!next) return "";
  const query = new URLSearchParams(asked);
  for (const [name, value] of Object.entries({ ...next, limit: PAGE, order: "newest" })) query.set(name, String(value));
  return query.toString();
}

/** Each once, with all that its reports tell, the newest report first. */
function joined(before: readonly Detection[], next: readonly Detection[]): readonly Detection[] {
  const all = new Map(before.map((one) => [keyOf(one), one]));
  for (const one of next) {
    const key = keyOf(one);
    const known = all.get(key);
    all.set(key, known ? completed(known, one) : one);
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
