// The alarm bar of every page, and the list under it: what is wrong, what to do, who knows.

import { getJson, postJson, reason } from "../api/http";
import type { Alarm, AlarmList, LiveFrame } from "../api/types.gen";
import { type Alarms, barText, DEAF_AGAIN_MS, DEAF_MS, newlySounding, NO_ALARMS, type Priority, SHAPES, told, withAlarms } from "../state/alarms";
import { alarmRow, named } from "./alarmrow";
import { type AlarmRows, type AlarmView, createAlarmView, createRows, drawCounts, drawPast } from "./alarmview";
import { setAttribute, setText } from "./dom";
import { hexAddress } from "./format";
import { createNotifier, type Notifier } from "./notify";
import { createSound, type Sound } from "./sound";
import { t } from "../words/words";

const PATIENCE_MS = 8_000;

export interface AlarmBar {
  frame(frame: LiveFrame): Alarms;
  /** The server is not heard any more: nothing is known of alarms from here on. */
  lost(): void;
  /** Sounds once as a warning does, where sound is on. */
  attention(): void;
}

/** `root` is the bar's place; `data-stops` as of the STOP buttons says whose alarms the person may acknowledge. */
export function createAlarms(root: HTMLElement): AlarmBar {
  return new Bar(root);
}

class Bar implements AlarmBar {
  private alarms: Alarms = NO_ALARMS;
  private sounded: Alarms | undefined;
  /** The server's time of the last frame, µs, and when it came, ms of the steady clock. */
  private heard: { readonly us: number; readonly ms: number } | undefined;
  /** Runs from when the server is not heard any more until it is heard again. */
  private deaf: number | undefined;
  private readonly names = new Map<number, string>();
  private readonly sound: Sound = createSound(() => this.drawSound());
  private readonly notifier: Notifier = createNotifier();
  private readonly view: AlarmView;
  private readonly rows: AlarmRows;
  /** Whose alarms the person may act on: addresses, or `all`. */
  private readonly listed: string;

  constructor(private readonly root: HTMLElement) {
    this.listed = root.dataset["stops"] ?? "";
    this.view = createAlarmView(root);
    this.rows = createRows(this.view.list, (alarm) => alarmRow(alarm, this.may(alarm), (path, body) => this.act(path, body)));
    this.view.arm.addEventListener("click", () => this.armOrMute());
    this.view.pastBox.addEventListener("toggle", () => {
      if (this.view.pastBox.open) void this.look();
    });
    this.draw();
  }

  attention(): void {
    this.sound.play("warning");
  }

  lost(): void {
    if (this.deaf !== undefined) return;
    // What cannot be told may be of any priority: it sounds as an alarm, and again until the server is heard.
    const sinceMs = this.heard ? performance.now() - this.heard.ms : 0;
    const tell = (): void => {
      this.sound.play("alarm");
      this.notifier.notify("deaf", barText(undefined, 0, this.heard?.us ?? null));
      this.deaf = window.setTimeout(tell, DEAF_AGAIN_MS);
    };
    this.deaf = window.setTimeout(tell, Math.max(0, DEAF_MS - sinceMs));
    this.draw();
  }

  frame(frame: LiveFrame): Alarms {
    const wasDeaf = this.deaf !== undefined;
    window.clearTimeout(this.deaf);
    this.deaf = undefined;
    this.heard = { us: frame.now_us, ms: performance.now() };
    const next = withAlarms(this.alarms, frame);
    for (const { address, name } of frame.systems) if (name) this.names.set(address, name);
    this.sounds(next);
    if (next !== this.alarms || wasDeaf) {
      this.alarms = next;
      this.draw();
    } else this.drawSound();
    return this.alarms;
  }

  /** Sounds where `next` has something louder than what sounded. */
  private sounds(next: Alarms): void {
    const louder = this.sounded ? newlySounding(this.sounded, next) : undefined;
    // What sounded before this page was opened is not repeated by a page that merely comes back.
    if (!this.sounded || next !== this.alarms) this.sounded = next;
    if (!louder) return;
    this.sound.play(louder);
    const [top] = told(next);
    if (top) this.notifier.notify(`alarm-${top.id}`, `${named(top.priority)}: ${barText(top, 0)}`);
  }

  private may({ vessel }: Alarm): boolean {
    const { listed } = this;
    return vessel === null ? listed !== "" : listed === "all" || listed.split(",").includes(String(vessel));
  }

  private vesselName(vessel: number | null): string {
    return vessel === null ? t("Server") : (this.names.get(vessel) ?? hexAddress(vessel));
  }

  private async act(path: string, body?: unknown): Promise<void> {
    this.view.failed("");
    try {
      const after = await postJson<Alarm>(`/api/v1/alarms/${path}`, PATIENCE_MS, body);
      this.alarms = withAlarms(this.alarms, { alarms: [after], snapshot: false } as unknown as LiveFrame);
      this.draw();
    } catch (error) {
      this.view.failed(reason(error));
    }
  }

  private armOrMute(): void {
    if (this.sound.armed) {
      this.sound.mute();
      this.drawSound();
      return;
    }
    this.notifier.ask();
    void this.sound.arm().then((heard) => {
      this.view.failed(heard ? "" : t("This browser plays no sound: watch the bar."));
      this.drawSound();
    });
  }

  private async look(): Promise<void> {
    try {
      const { history } = await getJson<AlarmList>("/api/v1/alarms");
      drawPast(this.view.past, history, (vessel) => this.vesselName(vessel));
    } catch (error) {
      this.view.failed(reason(error));
    }
  }

  private drawSound(): void {
    const { arm } = this.view;
    setText(arm, this.sound.armed ? t("Sound on: mute") : t("Sound off: turn on"));
    setAttribute(arm, "data-armed", this.sound.armed ? "" : null);
  }

  private draw(): void {
    const { view, rows } = this;
    const all = told(this.alarms);
    const shelved = [...this.alarms.values()].filter((one) => one.shelved);
    rows.keep(new Set([...all, ...shelved].map((one) => one.id)));
    drawCounts(view.numbers, all);
    this.drawBar(all, shelved.length);
    setAttribute(view.asideTitle, "hidden", shelved.length ? null : "");
    rows.fill(view.rows, all);
    rows.fill(view.aside, shelved);
    this.drawSound();
  }

  /** What the bar says of the most urgent of `all`, to eyes and to screen readers. */
  private drawBar(all: readonly Alarm[], shelved: number): void {
    const { root, view, heard } = this;
    const [top] = all;
    const text = barText(top, shelved);
    this.notifier.title(top && top.priority !== "caution" ? `${SHAPES[top.priority as Priority] ?? ""} ${text}` : "");
    const unknown = this.deaf === undefined ? "" : barText(top, shelved, heard?.us ?? null);
    const shownText = heard || unknown ? unknown || text : t("Alarms not loaded yet");
    setText(view.worst, shownText);
    setText(view.none, unknown || !heard ? `${shownText}.` : t("No alarms."));
    setAttribute(root, "data-deaf", unknown ? "" : null);
    setAttribute(root, "data-priority", top?.priority ?? null);
    setAttribute(root, "data-open", all.some((one) => one.wants_acknowledgement && one.state === "unacknowledged") ? "" : null);
    // Only what nobody knows of yet is read out, and once.
    const said = top && top.wants_acknowledgement ? `${named(top.priority)}: ${text}` : "";
    const loud = top?.priority === "emergency" || top?.priority === "alarm";
    setText(view.urgent, unknown || (loud ? said : ""));
    setText(view.calm, unknown || loud ? "" : said);
    setAttribute(view.none, "hidden", all.length && !unknown ? "" : null);
  }
}
