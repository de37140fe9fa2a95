// What stands on every page: whether the server is heard, trouble with the recording, STOP, the palette.

import { postForm } from "../api/http";
import { Live, type Wanted } from "../api/live";
import { linkIs } from "../api/traffic";
import type { LiveFrame, LiveStop, System } from "../api/types.gen";
import { type Alarms, NO_ALARMS } from "../state/alarms";
import { EMPTY, type FleetState, withFrame } from "../state/fleet";
import { unheard } from "../state/order";
import { windowKey } from "../state/window";
import { t, tn } from "../words/words";
import { createAlarms } from "./alarms";
import { createBoundary } from "./boundary";
import { setAttribute, setText } from "./dom";
import { createHelp } from "./help";
import { keepInSight } from "./insight";
import { createKeepControl } from "./keepcontrol";
import { createMenu } from "./menu";
import { createRequests } from "./requests";
import { createStop, type Stop } from "./stop";
import { asCalled, hexAddress, systemName } from "./format";
import { createCalendars } from "./when";

/** The palette is kept by the server within this, or not at all, ms. */
const PALETTE_MS = 8_000;

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
  /** Draws a part of the page. While a part fails, the page is grey and says so. */
  draw(part: string, work: () => void): void;
}

/** Watches the server by the page's subscription. */
export function createChrome(subscription: Wanted, handlers: ChromeHandlers): Chrome {
  const link = document.getElementById("link");
  const trouble = document.getElementById("trouble");
  const [buttons, orders] = [document.getElementById("stop"), document.getElementById("orders")];
  const line = {
    stop: (stop: LiveStop): void => live.stop(stop),
    giveUp: (key: string): void => live.giveUp(key),
  };
  const names = givenNames();
  const stop = buttons && orders ? createStop(buttons, orders, line, names) : undefined;
  const asked = document.getElementById("requests");
  const requests = asked ? createRequests(asked, asked.dataset["me"] ?? "") : undefined;
  const kept = asked ? createKeepControl(asked, asked.dataset["me"] ?? "") : undefined;
  const alarmBox = document.getElementById("alarms");
  const bar = alarmBox ? createAlarms(alarmBox) : undefined;
  let alarms = NO_ALARMS;
  let state = EMPTY;
  let heard: boolean | undefined;
  const boundary = createBoundary(() => tell());
  /** Live is what was drawn of what is heard. */
  const tell = (): void => {
    const failed = boundary.failed();
    if (heard === undefined && !failed) return;
    setAttribute(document.body, "data-link", heard && !failed ? "up" : "down");
    if (!link) return;
    if (failed) setText(link, t("This page failed: what you see may be old. STOP works. Reload the page."));
    else if (heard) setText(link, state.eventsMissed ? tn(state.eventsMissed, "Live · {n} event only in the history", "Live · {n} events only in the history") : t("Live"));
    else setText(link, t("No link to the server: what you see is old. Trying again …"));
  };
  palette();
  createMenu();
  createHelp();
  keepInSight();
  createCalendars();
  // On every page, so that the key goes on with the tab.
  windowKey();
  const loggedOut = (): void => location.assign(`/login?next=${encodeURIComponent(location.pathname + location.search)}`);
  stop?.vessels(named(EMPTY, names), false);
  // A page that follows some vessels only has all of them under STOP: of the others it hears what they do.
  const live = new Live(subscription.systems ? { ...subscription, of_others: ["VehicleState"] } : subscription, {
    frame(frame, atMs) {
      linkIs(true);
      heard = true;
      // Each by itself: what fails takes no other part with it, and STOP least of all.
      boundary.take("state", () => (state = withFrame(state, frame, atMs)));
      boundary.take("stop", () => {
        stop?.frame(frame);
        stop?.vessels(named(state, names), true);
      });
      boundary.take("trouble", () => {
        if (!trouble) return;
        setAttribute(trouble, "hidden", state.recording ? null : "");
        setText(trouble, state.recording ? t("Recording: {recording}", { recording: state.recording }) : "");
      });
      boundary.take("requests", () => {
        requests?.frame(frame, (address) => called(state, names, address));
        kept?.frame(frame, (address) => called(state, names, address));
      });
      boundary.take("alarms", () => {
        if (bar) alarms = bar.frame(frame);
      });
      boundary.take("page", () => handlers.frame?.(state, frame));
      tell();
    },
    lost() {
      linkIs(false);
      heard = false;
      boundary.take("stop", () => stop?.vessels(named(state, names), false));
      tell();
      boundary.take("alarms", () => bar?.lost());
      boundary.take("page", () => handlers.lost?.());
    },
    loggedOut,
    stopped: (answer) => stop?.stopped(answer),
  });
  return { stop, alarms: () => alarms, attention: () => bar?.attention(), draw: boundary.draw };
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

/** All that there are, with those that have a name from people, whether they are heard or not. */
function named(state: FleetState, names: Names): System[] {
  const silent = Object.entries(names).filter(([address]) => !state.systems.has(Number(address)));
  return asCalled([...state.systems.values(), ...silent.map(([address, name]) => unheard(Number(address), name))], names).sort((one, other) => systemName(one).localeCompare(systemName(other)));
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
    postForm(form.action, body, PALETTE_MS).catch(() => undefined);
  });
}
