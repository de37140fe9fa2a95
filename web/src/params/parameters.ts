// The Parameters tab: read from the vessel, change, write with read-back, save for its next start.

import { reason } from "../api/http";
import type { LiveFrame, System } from "../api/types.gen";
import { createOrders, windowKey } from "../control/orders";
import { type ControlState, type Part, partOf, whoHas } from "../state/control";
import { setAttribute, setText } from "../ui/dom";
import { age } from "../ui/format";
import { ParameterView } from "./view";
import { createReader, type Reader } from "./reading";
import { askSave } from "./saving";
import { askWrite } from "./writing";
import { t, tn } from "../words/words";

/** Changes that others make are looked at so long after they were heard, ms. */
const SETTLE_MS = 500;

export interface ParameterNeeds {
  readonly address: number;
  readonly me: string;
  /** Whether the person may command this vessel. */
  readonly may: boolean;
  name(): string;
  /** Leads to where control is taken. */
  openControl(): void;
}

export interface ParameterPanel {
  /** `moves`: whether the vessel is under way, or nobody knows. */
  update(control: ControlState, system: System | undefined, nowUs: number, moves: boolean, shown: boolean): void;
  heard(frame: LiveFrame): void;
}

export function createParameters(root: HTMLElement, { address, me, may, name, openControl }: ParameterNeeds): ParameterPanel {
  const path = `/api/v1/vessels/${address}`;
  const [key, reader] = [windowKey(), createReader(path)];
  const orders = createOrders(address, key);
  const view: ParameterView = new ParameterView(root, address, may, name, reader, {
    read: () => void read(view, reader),
    write: () => askWrite(view, orders, reader),
    forget: () => view.forget(),
    save: () => askSave(view, orders, reader),
    openControl,
  });
  let begun = false;
  let settle: number | undefined;

  return {
    update(control, now, nowUs, underWay, shown) {
      [view.system, view.moves] = [now, underWay];
      const part = partOf(control.lease, me, key);
      const before = view.inControl;
      view.inControl = part === "here";
      if (before && !view.inControl) view.confirm.close();
      if (before !== view.inControl) view.enable();
      if (!shown) return;
      if (!begun && now) {
        begun = true;
        void view.look().then(() => (view.live ? read(view, reader) : view.draw()));
      }
      sayWho(view, control, part, nowUs);
      if (view.told) view.table.ages(view.told, nowUs);
    },
    heard({ events }) {
      if (!begun || view.busy || !events.some((one) => one.system === address && one.abbrev === "EntityParameters")) return;
      window.clearTimeout(settle);
      settle = window.setTimeout(() => void (view.busy || view.look()), SETTLE_MS);
    },
  };
}

/** Asks the vessel for all its parameters. */
async function read(view: ParameterView, reader: Reader): Promise<void> {
  if (view.busy) return;
  const { said, fail } = view.form;
  const name = view.name();
  view.begin(t("Asking {name} for its parameters …", { name }));
  try {
    const { told: now, silent, reached } = await reader.read();
    const answered = now.entities.length > 0 && !now.recorded;
    view.silence = !reached ? t("{name} has no connection at present.", { name: view.name() }) : answered ? "" : t("{name} did not answer. See whether it is heard (Link, above) and ask again; some programs report no parameters at all.", { name: view.name() });
    setText(said, view.silence || (silent.length ? tn(silent.length, "Read. 1 part of the vessel reported no parameters.", "Read. {n} parts of the vessel reported no parameters.") : t("Read.")));
    view.take(now);
  } catch (error) {
    setText(said, "");
    fail(reason(error));
    await view.look();
  }
  view.end();
}

/** Who has control, and how old the values are where the vessel is not heard. */
function sayWho({ form: { who, lead }, told, live, may, inControl, name }: ParameterView, control: ControlState, part: Part, nowUs: number): void {
  const [oldest] = [...(told?.entities ?? [])].map((one) => one.time_us).sort((one, other) => one - other);
  const old = told && oldest !== undefined && !live ? lastKnown(name(), told.recorded, age(Math.max(0, (nowUs - oldest) / 1e6))) : "";
  const control_ = may ? (inControl ? t("You have control: changes can be written.") : `${whoHas(control.lease, part)} ${t("Writing takes control.")}`) : t("Writing takes the role operator.");
  const words = `${control_}${old}`;
  if (who.firstChild?.textContent !== words) who.replaceChildren(words, ...(may && !inControl ? [" ", lead] : []));
  setAttribute(who, "data-old", old ? "" : null);
}

/** What is said of values that are not of the present; it follows another sentence. */
function lastKnown(name: string, recorded: boolean, oldest: string): string {
  const values = { name, age: oldest };
  return ` ${recorded ? t("{name} is not heard: these are its last known values from the history, {age} old.", values) : t("{name} is not heard: these are its last known values, {age} old.", values)}`;
}
