// The explorer: what was heard of which tag, when and where, by a question that stands in the page's address.

import { computed, signal } from "@preact/signals";
import { render } from "preact";
import { look, type Looked, lookedBackTo } from "../api/looking";
import { type Resource, resource } from "../api/resource";
import type { Detections, DetectionsSummary, ExportSize, Recorded, RegisterAnswer } from "../api/types.gen";
import { Choices } from "../components/choices";
import { ExploreMap } from "../components/exploremap";
import { Abacus, Bars, Effort } from "../components/exploreplots";
import { Spans, TimeSpan } from "../components/timespan";
import { apiOf, type Asked, askedOf, askedWrong, confirmedFrom, countedFrom, hoursText, projectsOf, searchOf, summaryOf } from "../state/explore";
import { flagReason, flagWord } from "../state/flags";
import { FORMATS } from "../state/register";
import { bytesText, picked } from "../state/takeout";
import { createChrome } from "../ui/chrome";
import { hexAddress, position, tagName, utc } from "../ui/format";
import { count, t, tn } from "../words/words";

/** While the server still reads it is asked again after this, ms. */
const AGAIN_MS = 400;
/** A server that has no room for a question is asked again so often. */
const TRIES = 30;
/** Rows of the table. */
const ROWS = 200;
const LAST_US = 9_007_199_254_740_991;

/** The newest detections of a question, as far as they are found. */
interface Listed extends Looked {
  readonly asked: string;
  readonly looking: boolean;
}

/** What the browser keeps with each question of this page. */
interface Step {
  /** How many questions of this page come before it: so many can be undone. */
  readonly before: number;
  /** Whether it was drawn over a plot. */
  readonly drawn: boolean;
}

function stepNow(): Step {
  const { before = 0, drawn = false } = (history.state ?? {}) as Partial<Step>;
  return { before, drawn };
}

/** What the page knows: the form, the question that is asked, and answers, each with its question: what answers another one is not shown. */
class Explore {
  readonly from = signal("");
  readonly to = signal("");
  readonly vessel = signal("");
  readonly tag = signal("");
  readonly project = signal<readonly string[]>([]);
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
  readonly step = signal(stepNow());
  /** How often a server without room was asked again. */
  readonly tries = signal(0);
  private readonly timers = { count: 0, measure: 0 };

  get form(): Asked {
    return { from: this.from.value, to: this.to.value, vessel: this.vessel.value, tag: this.tag.value, project: this.project.value, area: this.area.value, axis: this.axis.value };
  }

  readonly wrong = computed(() => askedWrong(this.form));
  readonly found = computed(() => (this.summary.path.value === summaryPath(this.askedNumbers.value) ? this.summary.value.value : undefined));
  readonly trouble = computed(() => (this.summary.busy.value || this.waits(this.summary) ? "" : this.summary.trouble.value));

  /** Fills the form from the page's address, and asks. */
  readonly read = (): void => {
    const asked = askedOf(location.search);
    [this.from.value, this.to.value, this.vessel.value, this.tag.value, this.project.value, this.area.value, this.axis.value] = [asked.from, asked.to, asked.vessel, asked.tag, asked.project, asked.area, asked.axis];
    this.drawing.value = false;
    this.step.value = stepNow();
    this.ask();
  };

  /** Puts the form into the page's address, and asks. */
  readonly show = (): void => this.goTo(false);

  private goTo(drawn: boolean): void {
    if (this.wrong.value) return;
    this.drawing.value = false;
    const search = searchOf(this.form);
    if (search !== location.search.slice(1)) {
      const step: Step = { before: this.step.value.before + 1, drawn };
      history.pushState(step, "", `${location.pathname}${search ? `?${search}` : ""}`);
      this.step.value = step;
    }
    this.ask();
  }

  /** Looks at a stretch of time, µs, that was drawn over a plot of the question that is asked. */
  readonly choose = (from: number, to: number): void => {
    const asked = askedOf(location.search);
    [this.vessel.value, this.tag.value, this.project.value, this.area.value, this.axis.value] = [asked.vessel, asked.tag, asked.project, asked.area, asked.axis];
    [this.from.value, this.to.value] = [picked(from), picked(to)];
    this.goTo(true);
  };

  /** Escape undoes what was drawn last, unless it is about a field or something that is open. */
  readonly escape = (event: KeyboardEvent): void => {
    const on = event.target instanceof Element ? event.target.closest("input, select, textarea, dialog, details[open], [role=application]") : null;
    if (event.key === "Escape" && !event.defaultPrevented && !on && this.step.value.drawn) history.back();
  };

  /** Plots to all times, or to where most are. */
  readonly stretch = (axis: string): void => {
    this.axis.value = axis;
    this.show();
  };

  /** Whether a server that had no room is asked again by itself. */
  waits({ againMs }: Pick<Resource<unknown>, "againMs">): boolean {
    return againMs.value > 0 && this.tries.value < TRIES;
  }

  private ask(): void {
    if (this.wrong.value) return;
    [this.asked.value, this.askedNumbers.value] = [apiOf(this.form), summaryOf(this.form)];
    window.clearTimeout(this.timers.measure);
    this.tries.value = 0;
    void this.count();
    const range = new URLSearchParams(this.asked.value);
    for (const [name, us] of [["from_us", 0], ["to_us", LAST_US]] as const) if (!range.has(name)) range.set(name, String(us));
    for (const [name, value] of [["order", "newest"], ["flags", "true"], ["limit", String(ROWS)]] as const) range.set(name, value);
    void this.list(range.toString());
  }

  private async count(): Promise<void> {
    window.clearTimeout(this.timers.count);
    const asked = this.askedNumbers.value;
    const found = await this.summary.ask(summaryPath(asked));
    if (asked !== this.askedNumbers.value) return;
    if (found?.read_from_us === null) {
      this.tries.value = 0;
      this.measure();
    } else if (found) this.timers.count = window.setTimeout(() => void this.count(), AGAIN_MS);
    else this.later(this.summary, "count", () => void this.count());
  }

  /** Asks again, after the time that a server without room has told. */
  private later(of: Pick<Resource<unknown>, "againMs">, name: "count" | "measure", ask: () => void): void {
    if (!this.waits(of)) return;
    this.tries.value++;
    window.clearTimeout(this.timers[name]);
    this.timers[name] = window.setTimeout(ask, of.againMs.value);
  }

  /** Fills the table from there on, below what is known. */
  readonly list = async (query: string, known: Looked["rows"] = []): Promise<void> => {
    const asked = this.asked.value;
    const tell = ({ rows, rest }: Looked, looking: boolean): void => { this.listed.value = { asked, rows: [...known, ...rows], rest, looking }; };
    tell({ rows: [], rest: query }, true);
    const looked = await look(this.rows, query, ROWS - known.length, (far) => tell(far, true));
    if (looked) tell(looked, false);
  };

  /** How large the file will be; asked once all is counted, where there are some. Of more than the server counts nobody knows it. */
  readonly measure = (): void => {
    const found = this.found.value;
    window.clearTimeout(this.timers.measure);
    if (!this.may || !found || found.detections === 0 || found.read_from_us !== null || found.left_out_before_us !== null) return;
    const path = this.sizePath;
    void this.size.ask(path).then((size) => {
      if (!size && path === this.sizePath) this.later(this.size, "measure", this.measure);
    });
  };

  /** The same, from the beginning. */
  readonly measureAnew = (): void => {
    this.tries.value = 0;
    this.measure();
  };

  get sizePath(): string {
    return `/api/v1/detections/size?${this.file}`;
  }

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
      <Choices label={t("Projects")} all={t("All projects")} options={projects.map((name) => [name, name] as const)} chosen={projectsOf(project.value, projects)} choose={(chosen) => (project.value = chosen)} />
      <button class="main">{t("Show")}</button>
      <Spans from={from} to={to} then={page.show} />
    </form>
  );
}

/** How many were counted; at least so many where that is not all. */
function manyText(n: number, all: boolean): string {
  const text = all ? tn(n, "1 detection.", "{n} detections.") : tn(n, "At least 1 detection.", "At least {n} detections.");
  return text.replace(/\d{4,}/, (digits) => count(Number(digits)));
}

/** How many there are, how far that is known, and what is wrong. */
function Told({ page }: Part) {
  const { summary, found: { value: found }, trouble: { value: trouble }, step: { value: step } } = page;
  const all = found && countedFrom(found) === undefined;
  const waiting = page.waits(summary) ? t("The server counts for others; it is asked again in a moment …") : summary.busy.value ? t("Fetching …") : "";
  return (
    <>
      {step.before > 0 && <p class="no-print"><button type="button" onClick={() => history.back()}>{t("Back to the question before")}</button></p>}
      {trouble && !/^tag: /.test(trouble) && <p class="bad-text" role="alert">{trouble} <button type="button" onClick={page.show}>{t("Try again")}</button></p>}
      <p role="status">{found ? manyText(found.detections, all ?? false) : waiting}{found && found.read_from_us !== null ? ` ${t("The server still reads: from {time} on so far.", { time: utc(found.read_from_us) })}` : ""}</p>
      {found && <LeftOut found={found} />}
      {found && <Outside page={page} found={found} />}
      {found && found.flags.length > 0 && <p>{all ? t("To be checked:") : t("To be checked, at least:")} {found.flags.map(({ code, detections }) => `${flagWord(code)} ${count(detections)}`).join(" · ")}</p>}
      {found?.detections === 0 && all && <p>{t("No tag was heard here in this time. Choose a longer time, another area, or all tags.")}</p>}
    </>
  );
}

/** What is not counted, and what of the rest is not known for it. */
function LeftOut({ found }: { readonly found: DetectionsSummary }) {
  const [before, confirmed] = [found.left_out_before_us, confirmedFrom(found)];
  if (before === null || confirmed === undefined) return null;
  return <p class="note warn">{t("Detections before {time} are left out: there are too many to show at once. Choose a shorter time.", { time: utc(before) })} {t("How many there are, and first and last times, are of those after it. Whether something confirms a detection is not known before {time}.", { time: utc(confirmed) })}</p>;
}

/** What lies outside the plots, with the way to see it. */
function Outside({ page, found: { outside, listened_outside_s } }: Part & { readonly found: DetectionsSummary }) {
  const way = (axis: string, text: string) => <a href={`?${searchOf({ ...page.form, axis })}`} onClick={(event) => { event.preventDefault(); page.stretch(axis); }}>{text}</a>;
  if (page.axis.value === "whole") return <p class="note">{way("", t("Leave out times of wrong clocks far from all others"))}</p>;
  if (!outside && !listened_outside_s) return null;
  return (
    <p class="note warn">
      {outside > 0 && <>{tn(outside, "1 detection lies outside the plots: a clock was not set or was wrong, and its time is far from all others.", "{n} detections lie outside the plots: clocks were not set or were wrong, and their times are far from all others.")} </>}
      {listened_outside_s > 0 && <>{t("{length} of listening lie outside the plots, far from all other times: perhaps a vessel's clock was wrong.", { length: hoursText(listened_outside_s) })} </>}
      {way("whole", t("Show all times"))}
    </p>
  );
}

function Download({ page }: Part) {
  const { size, format, asked, found } = page;
  const known = size.path.value === page.sizePath ? size.value.value : undefined;
  const waits = size.busy.value || page.waits(size) || found.value?.read_from_us !== null;
  const wrong = waits || known ? "" : size.trouble.value;
  const how = known && { n: count(known.rows), size: bytesText(known.bytes) };
  const told = how ? (known.estimated ? t("About {n} rows, about {size}.", how) : t("{n} rows, {size}.", how)) : waits ? t("Looking how large it will be …") : "";
  const unknown = found.value && found.value.left_out_before_us !== null;
  return (
    <section aria-label={t("Download")} key={asked.value}>
      <h2>{t("Download")}</h2>
      <p class="row"><label class="inline">{t("Format")} <select value={format.value} onChange={(event) => { format.value = event.currentTarget.value; page.measureAnew(); }}>{FORMATS.map(([name, about]) => <option key={name} value={name}>{about}</option>)}</select></label><a class="button" href={`/api/v1/detections.csv?${page.file}`} download>{t("Download these detections")}</a><a class="button" href={`/datasets?make=1&${location.search.slice(1)}`}>{t("Make a dataset of this")}</a></p>
      <p role="status">{unknown ? t("How large it will be is not known: there are more than the server counts beforehand. The file leaves nothing out.") : told}</p>
      {!unknown && wrong && <p class="bad-text" role="alert">{wrong} <button type="button" onClick={page.measureAnew}>{t("Try again")}</button></p>}
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
          <thead><tr>{[t("Heard (UTC)"), t("Tag"), t("Vessel"), t("SNR (dB)"), t("Place of the vessel"), t("Nearest other (s)"), t("Check")].map((head) => <th key={head} scope="col">{head}</th>)}</tr></thead>
          <tbody>
            {all.map((one) => (
              <tr key={`${one.system}/${one.id}`}>
                <td class="num">{one.heard_us === null ? t("{time} (reported)", { time: utc(one.time_us) }) : utc(one.heard_us)}</td>
                <td class="whole">{tagName(one)}</td><td class="whole">{page.called(one.system)}</td><td>{one.snr_db ?? ""}</td>
                <td>{one.lat_deg === null || one.lon_deg === null ? t("not known") : position({ lat_deg: one.lat_deg, lon_deg: one.lon_deg })}</td>
                <td class="num">{one.min_lag_s === null ? (one.flags === null ? t("not known") : "") : one.min_lag_s.toFixed(1)}</td>
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
        {found && found.detections > 0 && <Abacus found={found} choose={page.choose} />}
        {found && found.bars.length > 0 && <Bars found={found} choose={page.choose} />}
        {found && found.from_us !== null && <Effort found={found} choose={page.choose} area={new URLSearchParams(page.asked.value).has("area")} />}
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
  window.addEventListener("keydown", page.escape);
  void page.recorded.ask("/api/v1/recorded");
  void page.register.ask("/api/v1/register?kind=project");
  page.read();
}
