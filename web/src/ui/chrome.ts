// What stands on every page: whether the server is heard, trouble with the recording, STOP, the palette.

import { Live } from "../api/live";
import type { LiveFrame, Subscription, System } from "../api/types.gen";
import { type Alarms, NO_ALARMS } from "../state/alarms";
import { EMPTY, type FleetState, withFrame } from "../state/fleet";
import { windowKey } from "../state/window";
import { createAlarms } from "./alarms";
import { setAttribute, setText } from "./dom";
import { createRequests } from "./requests";
import { createStop, type Stop } from "./stop";
import { asCalled, hexAddress, systemName } from "./format";

export interface ChromeHandlers {
  /** A frame came. */
  frame?(state: FleetState, frame: LiveFrame): void;
  /** The server is not heard any more. */
  lost?(): void;
}

export interface Chrome {
  readonly stop: Stop | undefined;
  /** What is wrong, of all vessels that the person may see. */
  alarms(): Alarms;
  /** Sounds once as a warning does, where sound is on. */
  attention(): void;
}

/** Watches the server by the page's subscription. */
export function createChrome(subscription: Subscription, handlers: ChromeHandlers): Chrome {
  const link = document.getElementById("link");
  const trouble = document.getElementById("trouble");
  const [buttons, orders] = [document.getElementById("stop"), document.getElementById("orders")];
  const stop = buttons && orders ? createStop(buttons, orders) : undefined;
  const asked = document.getElementById("requests");
  const requests = asked ? createRequests(asked, asked.dataset["me"] ?? "") : undefined;
  const alarmBox = document.getElementById("alarms");
  const bar = alarmBox ? createAlarms(alarmBox) : undefined;
  const names = givenNames();
  let alarms = NO_ALARMS;
  let state = EMPTY;
  palette();
  keepInSight();
  // On every page, so that the key goes on with the tab.
  windowKey();
  const loggedOut = (): void => location.assign(`/login?next=${encodeURIComponent(location.pathname + location.search)}`);
  if (stop && subscription.systems) everyVessel(stop, names, loggedOut);
  new Live(subscription, {
    frame(frame, atMs) {
      state = withFrame(state, frame, atMs);
      setAttribute(document.body, "data-link", "up");
      if (link) setText(link, state.eventsMissed ? `Live · ${state.eventsMissed} events only in the history` : "Live");
      if (trouble) {
        setAttribute(trouble, "hidden", state.recording ? null : "");
        setText(trouble, state.recording ? `Recording: ${state.recording}` : "");
      }
      stop?.frame(frame);
      if (!subscription.systems) stop?.vessels(named(state, names));
      requests?.frame(frame, (address) => called(state, names, address));
      if (bar) alarms = bar.frame(frame);
      handlers.frame?.(state, frame);
    },
    lost() {
      setAttribute(document.body, "data-link", "down");
      if (link) setText(link, "No link to the server: what you see is old. Trying again …");
      bar?.lost();
      handlers.lost?.();
    },
    loggedOut,
  });
  return { stop, alarms: () => alarms, attention: () => bar?.attention() };
}

/** A page that follows some vessels only has all of them under STOP: what they do is heard beside it, and little of it. */
function everyVessel(stop: Stop, names: Names, loggedOut: () => void): void {
  let all = EMPTY;
  new Live({ messages: ["VehicleState"], events: false, every_ms: 1_000 }, {
    frame(frame, atMs) {
      all = withFrame(all, frame, atMs);
      stop.frame(frame);
      stop.vessels(named(all, names));
    },
    lost: () => undefined,
    loggedOut,
  });
}

function called(state: FleetState, names: Names, address: number): string {
  const system = state.systems.get(address);
  return names[String(address)] ?? (system ? systemName(system) : hexAddress(address));
}

type Names = Readonly<Record<string, string>>;

/** The names that people gave vessels, where the page has them. */
function givenNames(): Names {
  const told = document.querySelector<HTMLElement>("[data-names], [data-vessels]")?.dataset;
  return JSON.parse(told?.["names"] ?? told?.["vessels"] ?? "{}") as Names;
}

function named(state: FleetState, names: Names): System[] {
  return asCalled([...state.systems.values()], names).sort((one, other) => systemName(one).localeCompare(systemName(other)));
}

/** What gets the focus is scrolled to below what stays at the top. */
function keepInSight(): void {
  const top = document.getElementById("top");
  if (!top) return;
  const { style } = document.documentElement;
  // Where only the bar stays, that counts.
  const height = (): number => (top.getClientRects().length ? top : (top.firstElementChild ?? top)).getBoundingClientRect().height;
  const tell = (): void => style.setProperty("--top-height", `${Math.round(height())}px`);
  const watch = new ResizeObserver(tell);
  watch.observe(top);
  for (const part of top.children) watch.observe(part);
}

/** Changes the palette without leaving the page: nobody looks away from a boat for its colours. */
function palette(): void {
  const form = document.querySelector<HTMLFormElement>("form.palette");
  form?.addEventListener("submit", (event) => {
    const button = event.submitter;
    if (!(button instanceof HTMLButtonElement)) return;
    event.preventDefault();
    document.documentElement.dataset["palette"] = button.value;
    for (const one of form.querySelectorAll("button")) one.setAttribute("aria-pressed", String(one === button));
    const body = new URLSearchParams();
    for (const [name, value] of new FormData(form, button)) if (typeof value === "string") body.append(name, value);
    // Where the server is not reached it is this page's palette alone.
    fetch(form.action, { method: "POST", body, redirect: "manual" }).catch(() => undefined);
  });
}
