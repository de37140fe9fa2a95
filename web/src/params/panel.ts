// The Parameters tab: read from the vessel, change, write with read-back, save for its next start.

import { reason } from "../api/http";
import type { LiveFrame, System } from "../api/types.gen";
import { createOrders, windowKey } from "../control/orders";
import { type ControlState, type Part, partOf, whoHas } from "../state/control";
import { setAttribute, setText } from "../ui/dom";
import { age } from "../ui/format";
import { ParameterPanel } from "./parameterpanel";
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
  const desk: ParameterPanel = new ParameterPanel(root, address, may, name, reader, {
    read: () => void read(desk, reader),
    write: () => askWrite(desk, orders, reader),
    forget: () => desk.forget(),
    save: () => askSave(desk, orders, reader),
    openControl,
  });
  let begun = false;
  let settle: number | undefined;

  return {
    update(control, now, nowUs, underWay, shown) {
      [desk.system, desk.moves] = [now, underWay];
      const part = partOf(control.lease, me, key);
      const before = desk.inControl;
      desk.inControl = part === "here";
      if (before && !desk.inControl) desk.confirm.close();
      if (before !== desk.inControl) desk.enable();
      if (!shown) return;
      if (!begun && now) {
        begun = true;
        void desk.look().then(() => (desk.live ? read(desk, reader) : desk.draw()));
      }
      sayWho(desk, control, part, nowUs);
      if (desk.told) desk.table.ages(desk.told, nowUs);
    },
    heard({ events }) {
      if (!begun || desk.busy || !events.some((one) => one.system === address && one.abbrev === "EntityParameters")) return;
      window.clearTimeout(settle);
      settle = window.setTimeout(() => void (desk.busy || desk.look()), SETTLE_MS);
    },
  };
}

/** Asks the vessel for all its parameters. */
async function read(desk: ParameterPanel, reader: Reader): Promise<void> {
  if (desk.busy) return;
  const { said, fail } = desk.form;
  const name = desk.name();
  desk.begin(t("Asking {name} for its parameters …", { name }));
  try {
    const { told: now, silent, reached } = await reader.read();
    const answered = now.entities.length > 0 && !now.recorded;
    desk.silence = !reached ? t("{name} has no connection at present.", { name: desk.name() }) : answered ? "" : t("{name} did not answer. See whether it is heard (Link, above) and ask again; some programs report no parameters at all.", { name: desk.name() });
    setText(said, desk.silence || (silent.length ? tn(silent.length, "Read. 1 part of the vessel reported none.", "Read. {n} parts of the vessel reported none.") : t("Read.")));
    desk.take(now);
  } catch (error) {
    setText(said, "");
    fail(reason(error));
    await desk.look();
  }
  desk.end();
}

/** Who has control, and how old the values are where the vessel is not heard. */
function sayWho({ form: { who, lead }, told, live, may, inControl, name }: ParameterPanel, control: ControlState, part: Part, nowUs: number): void {
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
