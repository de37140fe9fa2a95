// The alarm bar of every page, and the list under it: what is wrong, what to do, who knows.

import { getJson, postJson, reason } from "../api/http";
import type { Alarm, AlarmList, LiveFrame } from "../api/types.gen";
import { type Alarms, barText, counts, DEAF_AGAIN_MS, DEAF_MS, newlySounding, NO_ALARMS, PRIORITIES, type Priority, SHAPES, stateText, told, whenText, withAlarms } from "../state/alarms";
import { make, setAttribute, setText } from "./dom";
import { hexAddress, utc } from "./format";
import { createNotifier } from "./notify";
import { createSound } from "./sound";

const PATIENCE_MS = 8_000;
/** For how long an alarm is shelved, minutes. */
const SHELF_MIN = [10, 30, 60, 240, 720];

export interface AlarmBar {
  frame(frame: LiveFrame): Alarms;
  /** The server is not heard any more: nothing is known of alarms from here on. */
  lost(): void;
  /** Sounds once as a warning does, where sound is on. */
  attention(): void;
}

/** `root` is the bar's place; `data-stops` as of the STOP buttons says whose alarms the person may acknowledge. */
export function createAlarms(root: HTMLElement): AlarmBar {
  const listed = root.dataset["stops"] ?? "";
  const may = ({ vessel }: Alarm): boolean => (vessel === null ? listed !== "" : listed === "all" || listed.split(",").includes(String(vessel)));
  const sound = createSound(() => drawSound());
  const notifier = createNotifier();
  let alarms: Alarms = NO_ALARMS;
  let sounded: Alarms | undefined;
  /** The server's time of the last frame, µs, and when it came, ms of the steady clock. */
  let heard: { readonly us: number; readonly ms: number } | undefined;
  /** Runs from when the server is not heard any more until it is heard again. */
  let deaf: number | undefined;
  const names = new Map<number, string>();
  const vesselName = (vessel: number | null): string => (vessel === null ? "Server" : (names.get(vessel) ?? hexAddress(vessel)));

  const numbers = make("span", { class: "counts" });
  const worst = make("span", { class: "worst" });
  const open = make("button", { type: "button", class: "open", "aria-expanded": "false", "aria-controls": "alarm-list" }, numbers, worst);
  const arm = make("button", { type: "button", class: "arm" }, "Sound off: turn on");
  // What is urgent interrupts a screen reader, what is not waits.
  const [urgent, calm] = [make("p", { class: "hidden", "aria-live": "assertive" }), make("p", { class: "hidden", "aria-live": "polite" })];
  const trouble = make("p", { class: "note bad", role: "alert", hidden: "" });
  const rows = make("ul", { class: "alarm-rows" });
  const asideTitle = make("h3", { hidden: "" }, "Shelved");
  const aside = make("ul", { class: "alarm-rows" });
  const past = make("ol", { class: "alarm-past" });
  const pastBox = make("details", {}, make("summary", {}, "What happened lately"), past, make("a", { href: "/alarms" }, "Alarm history"));
  const none = make("p", { class: "empty" }, "No alarms.");
  const list = make("div", { id: "alarm-list", class: "alarm-list", role: "region", "aria-label": "Alarms", tabindex: "-1", hidden: "" }, trouble, none, rows, asideTitle, aside, pastBox);
  root.append(make("div", { class: "alarm-bar" }, open, arm), urgent, calm, list);

  const failed = (text: string): void => {
    setText(trouble, text);
    setAttribute(trouble, "hidden", text ? null : "");
  };
  const act = async (path: string, body?: unknown): Promise<void> => {
    failed("");
    try {
      const after = await postJson<Alarm>(`/api/v1/alarms/${path}`, PATIENCE_MS, body);
      alarms = withAlarms(alarms, { alarms: [after], snapshot: false } as unknown as LiveFrame);
      draw();
    } catch (error) {
      failed(reason(error));
    }
  };
  open.addEventListener("click", () => {
    const opened = open.getAttribute("aria-expanded") !== "true";
    setAttribute(open, "aria-expanded", String(opened));
    setAttribute(list, "hidden", opened ? null : "");
    if (opened) list.focus();
  });
  list.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || open.getAttribute("aria-expanded") !== "true") return;
    open.click();
    open.focus();
  });
  arm.addEventListener("click", () => {
    if (sound.armed) {
      sound.mute();
      drawSound();
      return;
    }
    notifier.ask();
    void sound.arm().then((heard) => {
      failed(heard ? "" : "This browser plays no sound: watch the bar.");
      drawSound();
    });
  });
  pastBox.addEventListener("toggle", () => {
    if (pastBox.open) void look();
  });
  const look = async (): Promise<void> => {
    try {
      const { history } = await getJson<AlarmList>("/api/v1/alarms");
      past.replaceChildren(...history.map((note) => make("li", {}, make("span", { class: "num" }, utc(note.time_us)), ` ${vesselName(note.vessel)}: ${note.priority} ${note.what}${note.by ? ` by ${note.by}` : ""}: ${note.text}`)));
      if (!history.length) past.append(make("li", {}, "Nothing since the server started."));
    } catch (error) {
      failed(reason(error));
    }
  };

  const shown = new Map<number, { readonly root: HTMLElement; drawn: string }>();
  const row = (alarm: Alarm): HTMLElement => {
    const title = `${alarm.vessel_name ?? "Server"}: ${alarm.text}`;
    const head = make("p", { class: "title" }, make("span", { class: "badge", "data-priority": alarm.priority }, `${SHAPES[alarm.priority as Priority] ?? ""} ${alarm.priority}`), " ", make("strong", {}, title));
    const times = alarm.count > 1 ? `, ${alarm.count} times` : "";
    const more = `${alarm.escalated ? "; more urgent because nobody acknowledged it" : ""}${alarm.chatters ? "; comes and goes, so it is held" : ""}`;
    const where = make("p", { class: "dim" }, `${stateText(alarm)} · ${whenText(alarm)}${times}${more}`);
    const advice = make("dl", {}, make("dt", {}, "What to do"), make("dd", {}, alarm.action), make("dt", {}, "If ignored"), make("dd", {}, alarm.consequence), make("dt", {}, "Why"), make("dd", {}, alarm.cause));
    const buttons = make("div", { class: "row" });
    if (may(alarm) && alarm.wants_acknowledgement) {
      const know = make("button", { type: "button", class: "main", "aria-label": `Acknowledge: ${title}` }, "Acknowledge");
      know.addEventListener("click", () => void act(`${alarm.id}/acknowledge`));
      buttons.append(know);
    }
    if (may(alarm) && alarm.priority !== "emergency" && !alarm.shelved) buttons.append(shelf(alarm, title));
    if (alarm.vessel !== null) buttons.append(make("a", { href: `/vessels/${alarm.vessel}`, "aria-label": `Open the vessel ${alarm.vessel_name}` }, "Open the vessel"));
    return make("li", { "data-alarm": alarm.kind, "data-state": alarm.state, "data-priority": alarm.priority }, head, where, advice, buttons);
  };
  const shelf = (alarm: Alarm, title: string): HTMLElement => {
    const minutes = make("select", { "aria-label": `For how long: ${title}` }, ...SHELF_MIN.map((one) => make("option", { value: String(one) }, one < 60 ? `${one} min` : `${one / 60} h`)));
    const why = make("input", { type: "text", maxlength: "300", required: "", "aria-label": `Why: ${title}`, placeholder: "why" });
    const form = make("form", { class: "row" }, minutes, why, make("button", { type: "submit" }, "Shelve"));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void act(`${alarm.id}/shelve`, { minutes: Number(minutes.value), reason: why.value.trim() });
    });
    return make("details", { class: "shelf" }, make("summary", {}, "Shelve …"), form);
  };
  const fill = (place: HTMLElement, all: readonly Alarm[]): void => {
    all.forEach((alarm, index) => {
      const drawn = JSON.stringify({ ...alarm, sounded: 0 });
      let one = shown.get(alarm.id);
      if (!one || one.drawn !== drawn) {
        const fresh = { root: row(alarm), drawn };
        if (one?.root.parentElement) {
          // Who was at this alarm stays at it, though not at another button under the same finger.
          const focused = one.root.contains(document.activeElement);
          one.root.replaceWith(fresh.root);
          if (focused) list.focus();
        }
        shown.set(alarm.id, fresh);
        one = fresh;
      }
      if (place.children[index] !== one.root) place.insertBefore(one.root, place.children[index] ?? null);
    });
  };

  const drawSound = (): void => {
    setText(arm, sound.armed ? "Sound on: mute" : "Sound off: turn on");
    setAttribute(arm, "data-armed", sound.armed ? "" : null);
  };
  const draw = (): void => {
    const all = told(alarms);
    const shelved = [...alarms.values()].filter((one) => one.shelved);
    const keep = new Set([...all, ...shelved].map((one) => one.id));
    for (const [id, one] of shown) {
      if (keep.has(id)) continue;
      one.root.remove();
      shown.delete(id);
    }
    const number = counts(all);
    const badges = PRIORITIES.filter((one) => number[one]).map((one) => ({ one, text: `${SHAPES[one]} ${number[one]}` }));
    const key = badges.map(({ one, text }) => one + text).join();
    if (numbers.dataset["key"] !== key) {
      numbers.dataset["key"] = key;
      numbers.replaceChildren(...badges.map(({ one, text }) => make("span", { class: "badge", "data-priority": one }, text, make("span", { class: "hidden" }, ` ${one}`))));
    }
    const [top] = all;
    const text = barText(top, shelved.length);
    notifier.title(top && top.priority !== "caution" ? `${SHAPES[top.priority as Priority] ?? ""} ${text}` : "");
    const unknown = deaf === undefined ? "" : barText(top, shelved.length, heard?.us ?? null);
    const shownText = heard || unknown ? unknown || text : "Alarms are not known yet";
    setText(worst, shownText);
    setText(none, unknown || !heard ? `${shownText}.` : "No alarms.");
    setAttribute(root, "data-deaf", unknown ? "" : null);
    setAttribute(root, "data-priority", top?.priority ?? null);
    setAttribute(root, "data-open", all.some((one) => one.wants_acknowledgement && one.state === "unacknowledged") ? "" : null);
    // Only what nobody knows of yet is read out, and once.
    const said = top && top.wants_acknowledgement ? `${top.priority}: ${text}` : "";
    const loud = top?.priority === "emergency" || top?.priority === "alarm";
    setText(urgent, unknown || (loud ? said : ""));
    setText(calm, unknown || loud ? "" : said);
    setAttribute(none, "hidden", all.length && !unknown ? "" : null);
    setAttribute(asideTitle, "hidden", shelved.length ? null : "");
    fill(rows, all);
    fill(aside, shelved);
    drawSound();
  };
  draw();

  return {
    attention: () => sound.play("warning"),
    lost() {
      if (deaf !== undefined) return;
      // What cannot be told may be of any priority: it sounds as an alarm, and again until the server is heard.
      const sinceMs = heard ? performance.now() - heard.ms : 0;
      const tell = (): void => {
        sound.play("alarm");
        notifier.notify("deaf", barText(undefined, 0, heard?.us ?? null));
        deaf = window.setTimeout(tell, DEAF_AGAIN_MS);
      };
      deaf = window.setTimeout(tell, Math.max(0, DEAF_MS - sinceMs));
      draw();
    },
    frame(frame) {
      const wasDeaf = deaf !== undefined;
      window.clearTimeout(deaf);
      deaf = undefined;
      heard = { us: frame.now_us, ms: performance.now() };
      const next = withAlarms(alarms, frame);
      for (const { address, name } of frame.systems) if (name) names.set(address, name);
      const louder = sounded ? newlySounding(sounded, next) : undefined;
      // What sounded before this page was opened is not repeated by a page that merely comes back.
      if (!sounded || next !== alarms) sounded = next;
      if (louder) {
        sound.play(louder);
        const [top] = told(next);
        if (top) notifier.notify(`alarm-${top.id}`, `${top.priority}: ${barText(top, 0)}`);
      }
      if (next !== alarms || wasDeaf) {
        alarms = next;
        draw();
      } else drawSound();
      return alarms;
    },
  };
}
