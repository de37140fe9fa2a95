// The explorer: what was heard of which tag, when and where, by a question that stands in the page's address.

import { computed, signal } from "@preact/signals";
import { render } from "preact";
import { look, type Looked, lookedBackTo } from "../api/looking";
import { resource } from "../api/resource";
import type { Detections, DetectionsSummary, ExportSize, Recorded, RegisterAnswer } from "../api/types.gen";
import { Choices } from "../components/choices";
import { ExploreMap } from "../components/exploremap";
import { Abacus, Bars, Effort } from "../components/exploreplots";
import { Spans, TimeSpan } from "../components/timespan";
import { apiOf, type Asked, askedOf, askedWrong, searchOf, summaryOf } from "../state/explore";
import { flagReason, flagWord } from "../state/flags";
import { FORMATS } from "../state/register";
import { bytesText } from "../state/takeout";
import { createChrome } from "../ui/chrome";
import { hexAddress, position, tagName, utc } from "../ui/format";
import { count, t, tn } from "../words/words";

/** While the server still reads it is asked again after this, ms. */
const AGAIN_MS = 400;
/** Rows of the table. */
const ROWS = 200;
const LAST_US = 9_007_199_254_740_991;

/** The newest detections of a question, as far as they are found. */
interface Listed extends Looked {
  readonly asked: string;
  readonly looking: boolean;
}

/** What the page knows: the form, the question that is asked, and answers, each with its question: what answers another one is not shown. */
class Explore {
  readonly from = signal("");
  readonly to = signal("");
  readonly vessel = signal("");
  readonly tag = signal("");
  readonly project = signal("");
  readonly area = signal("");
  readonly axis = signal("");
  readonly drawing = signal(false);
  readonly format = signal("lutra");
  readonly summary = resource<DetectionsSummary>();
  readonly rows = resource<Detections>();
  readonly size = resource<ExportSize>();
  readonly register = resource<RegisterAnswer>();
  readonly recorded = resource<Recorded[]>();
  /** Which detections; and which numbers of them. */
  readonly asked = signal("");
  readonly askedNumbers = signal("");
  readonly listed = signal<Listed | undefined>(undefined);
  private timer = 0;

  get form(): Asked {
    return { from: this.from.value, to: this.to.value, vessel: this.vessel.value, tag: this.tag.value, project: this.project.value, area: this.area.value, axis: this.axis.value };
  }

  readonly wrong = computed(() => askedWrong(this.form));
  readonly found = computed(() => (this.summary.path.value === summaryPath(this.askedNumbers.value) ? this.summary.value.value : undefined));
  readonly trouble = computed(() => (this.summary.busy.value ? "" : this.summary.trouble.value));

  /** Fills the form from the page's address, and asks. */
  readonly read = (): void => {
    const asked = askedOf(location.search);
    [this.from.value, this.to.value, this.vessel.value, this.tag.value, this.project.value, this.area.value, this.axis.value] = [asked.from, asked.to, asked.vessel, asked.tag, asked.project, asked.area, asked.axis];
    this.drawing.value = false;
    this.ask();
  };

  /** Puts the form into the page's address, and asks. */
  readonly show = (): void => {
    if (this.wrong.value) return;
    this.drawing.value = false;
    const search = searchOf(this.form);
    if (search !== location.search.slice(1)) history.pushState(null, "", `${location.pathname}${search ? `?${search}` : ""}`);
    this.ask();
  };

  /** Plots to all times, or to where most are. */
  readonly stretch = (axis: string): void => {
    this.axis.value = axis;
    this.show();
  };

  private ask(): void {
    if (this.wrong.value) return;
    [this.asked.value, this.askedNumbers.value] = [apiOf(this.form), summaryOf(this.form)];
    void this.count();
    const range = new URLSearchParams(this.asked.value);
    for (const [name, us] of [["from_us", 0], ["to_us", LAST_US]] as const) if (!range.has(name)) range.set(name, String(us));
    for (const [name, value] of [["order", "newest"], ["flags", "true"], ["limit", String(ROWS)]] as const) range.set(name, value);
    void this.list(range.toString());
  }

  private async count(): Promise<void> {
    window.clearTimeout(this.timer);
    const found = await this.summary.ask(summaryPath(this.askedNumbers.value));
    if (!found) return;
    if (found.read_from_us === null) this.measure();
    else this.timer = window.setTimeout(() => void this.count(), AGAIN_MS);
  }

  /** Fills the table from there on, below what is known. */
  readonly list = async (query: string, known: Looked["rows"] = []): Promise<void> => {
    const asked = this.asked.value;
    const tell = ({ rows, rest }: Looked, looking: boolean): void => { this.listed.value = { asked, rows: [...known, ...rows], rest, looking }; };
    tell({ rows: [], rest: query }, true);
    const looked = await look(this.rows, query, ROWS - known.length, (far) => tell(far, true));
    if (looked) tell(looked, false);
  };

  /** How large the file will be; asked once all is counted. */
  readonly measure = (): void => {
    if (this.may && this.found.value?.read_from_us === null) void this.size.ask(`/api/v1/detections/size?${this.file}`);
  };

  get file(): string {
    const query = new URLSearchParams(this.asked.value);
    if (this.format.value !== "lutra") query.set("format", this.format.value);
    return query.toString();
  }

  constructor(readonly called: (address: number) => string, readonly names: readonly number[], readonly may: boolean) {}
}

function summaryPath(asked: string): string {
  return `/api/v1/detections/summary?${asked}`;
}

interface Part {
  readonly page: Explore;
}

function Form({ page }: Part) {
  const { from, to, vessel, tag, project, wrong } = page;
  const vessels = [...new Set([...page.names, ...(page.recorded.value.value ?? []).map(({ system }) => system)])];
  const projects = (page.register.value.value?.entries ?? []).map(({ record }) => record.name);
  const said = /^(tag|project|area|vessel): (.*)$/s.exec(page.trouble.value);
  const tagWrong = said?.[1] === "tag" ? (said[2] ?? "") : "";
  return (
    <form class="filters" aria-label={t("What to look at")} onSubmit={(event) => { event.preventDefault(); page.show(); }}>
      <TimeSpan from={from} to={to} toWrong={wrong.value} />
      <div class="field">
        <label for="tags">{t("Tags")}</label>
        <input id="tags" value={tag.value} placeholder="S256-101, 102" autocomplete="off" aria-invalid={tagWrong !== ""} aria-describedby="tags-wrong" onInput={(event) => (tag.value = event.currentTarget.value)} />
        <p id="tags-wrong" class="wrong" role="alert">{tagWrong}</p>
      </div>
      <Choices label={t("Vessels")} all={t("All vessels")} options={vessels.map((address) => [String(address), page.called(address)] as const)} chosen={vessel.value.split(",").filter(Boolean)} choose={(chosen) => (vessel.value = chosen.join(","))} />
      <Choices label={t("Projects")} all={t("All projects")} options={projects.map((name) => [name, name] as const)} chosen={project.value.split(";").map((name) => name.trim()).filter(Boolean)} choose={(chosen) => (project.value = chosen.join(";"))} />
      <button class="main">{t("Show")}</button>
      <Spans from={from} to={to} then={page.show} />
    </form>
  );
}

/** How many there are, how far that is known, and what is wrong. */
function Told({ page }: Part) {
  const { summary, found: { value: found }, trouble: { value: trouble } } = page;
  const many = found ? tn(found.detections, "1 detection.", "{n} detections.").replace(/\d{4,}/, (digits) => count(Number(digits))) : "";
  return (
    <>
      {trouble && !/^tag: /.test(trouble) && <p class="bad-text" role="alert">{trouble} <button type="button" onClick={page.show}>{t("Try again")}</button></p>}
      <p role="status">{!found && summary.busy.value ? t("Fetching …") : many}{found && found.read_from_us !== null ? ` ${t("The server still reads: from {time} on so far.", { time: utc(found.read_from_us) })}` : ""}</p>
      {found && found.left_out_before_us !== null && <p class="note warn">{t("Detections before {time} are left out: there are too many to show at once. Choose a shorter time.", { time: utc(found.left_out_before_us) })}</p>}
      {found && found.outside > 0 && <p class="note warn">{tn(found.outside, "1 detection has a time far from all others and lies outside the plots: perhaps a clock was wrong, perhaps the tag was heard at another time of the year.", "{n} detections have times far from all others and lie outside the plots: perhaps a clock was wrong, perhaps tags were heard at another time of the year.")} <button type="button" onClick={() => page.stretch("whole")}>{t("Show all times")}</button></p>}
      {found && page.axis.value === "whole" && <p class="note"><button type="button" onClick={() => page.stretch("")}>{t("Leave out times far from all others")}</button></p>}
      {found && found.flags.length > 0 && <p>{t("Look twice at:")} {found.flags.map(({ code, detections }) => `${flagWord(code)} ${count(detections)}`).join(" · ")}</p>}
      {found?.detections === 0 && found.read_from_us === null && <p>{t("No tag was heard here in this time. Choose a longer time, another area, or all tags.")}</p>}
    </>
  );
}

function Download({ page }: Part) {
  const { size, format, asked, found } = page;
  const known = size.path.value === `/api/v1/detections/size?${page.file}` ? size.value.value : undefined;
  const waits = size.busy.value || found.value?.read_from_us !== null;
  const told = waits ? t("Looking how large it will be …") : size.trouble.value || (known ? t("{n} rows, about {size}.", { n: count(known.rows), size: bytesText(known.bytes) }) : "");
  return (
    <section aria-label={t("Download")} key={asked.value}>
      <h2>{t("Download")}</h2>
      <p class="row"><label class="inline">{t("Format")} <select value={format.value} onChange={(event) => { format.value = event.currentTarget.value; page.measure(); }}>{FORMATS.map(([name, about]) => <option key={name} value={name}>{about}</option>)}</select></label><a class="button" href={`/api/v1/detections.csv?${page.file}`} download>{t("Download these detections")}</a><a class="button" href={`/datasets?make=1&${location.search.slice(1)}`}>{t("Make a dataset of this")}</a></p>
      <p role="status">{told}</p>
    </section>
  );
}

function Table({ page }: Part) {
  const { rows, listed: { value: listed } } = page;
  if (!rows.busy.value && rows.trouble.value) return rows.trouble.value === page.trouble.value ? null : <p class="bad-text" role="alert">{rows.trouble.value}</p>;
  if (!listed || listed.asked !== page.asked.value) return null;
  const all = listed.rows;
  const how = { n: all.length, time: utc(Math.min(Date.now() * 1_000, lookedBackTo(listed.rest))) };
  if (!all.length && !listed.looking && !listed.rest) return null;
  return (
    <section aria-label={t("Newest detections")}>
      <h2>{tn(all.length, "1 newest detection.", "{n} newest detections.")}</h2>
      {listed.looking && <p role="status">{t("Still looking: {n} found, back to {time} so far.", how)}</p>}
      {!listed.looking && listed.rest && all.length < ROWS && <p class="note">{t("Looked back to {time}: {n} found.", how)} <button type="button" onClick={() => void page.list(listed.rest, all)}>{t("Look further back")}</button></p>}
      {all.length > 0 && <div class="wide" tabIndex={0} role="region" aria-label={t("Detections")}>
        <table class="compact">
          <thead><tr>{[t("Heard (UTC)"), t("Tag"), t("Vessel"), t("SNR (dB)"), t("Place of the vessel"), t("Nearest other (s)"), t("Look twice")].map((head) => <th key={head} scope="col">{head}</th>)}</tr></thead>
          <tbody>
            {all.map((one) => (
              <tr key={`${one.system}/${one.id}`}>
                <td class="num">{one.heard_us === null ? t("{time} (reported)", { time: utc(one.time_us) }) : utc(one.heard_us)}</td>
                <td class="whole">{tagName(one)}</td><td class="whole">{page.called(one.system)}</td><td>{one.snr_db}</td>
                <td>{one.lat_deg === null || one.lon_deg === null ? t("not known") : position({ lat_deg: one.lat_deg, lon_deg: one.lon_deg })}</td>
                <td class="num">{one.min_lag_s === null ? "" : one.min_lag_s.toFixed(1)}</td>
                <td>{one.flags === null ? t("not known") : one.flags.map((flag) => flagReason(flag)).join(" ")}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>}
    </section>
  );
}

export function startExplore(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["names"] ?? "{}") as Record<string, string>;
  const called = (address: number): string => names[String(address)] ?? hexAddress(address);
  const page = new Explore(called, Object.keys(names).map(Number), root.dataset["researcher"] !== undefined);
  const Page = () => {
    const found = page.found.value;
    return (
      <>
        <Form page={page} />
        <Told page={page} />
        {found && found.detections > 0 && <Abacus found={found} />}
        {found && found.bars.length > 0 && <Bars found={found} />}
        {found && found.from_us !== null && <Effort found={found} area={new URLSearchParams(page.asked.value).has("area")} />}
        <ExploreMap found={found} area={page.area} drawing={page.drawing} done={page.show} />
        {page.may && found && found.detections > 0 && <Download page={page} />}
        <Table page={page} />
      </>
    );
  };
  root.replaceChildren();
  render(<Page />, root);
  createChrome({ messages: ["VehicleState"], events: false, every_ms: 500 }, {});
  window.addEventListener("popstate", page.read);
  void page.recorded.ask("/api/v1/recorded");
  void page.register.ask("/api/v1/register?kind=project");
  page.read();
}
