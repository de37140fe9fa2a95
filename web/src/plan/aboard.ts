// Bringing a plan aboard: which vessel, whether its copy is the shore's, and the vessel's control beside it.

import { getJson, postJson, reason } from "../api/http";
import type { Command, LiveFrame, PlansAboard, PlanUploadAsk, System } from "../api/types.gen";
import { type ControlPanel, createControl } from "../control/panel";
import { createOrders, windowKey } from "../control/orders";
import { type ControlState, NO_CONTROL, withControls } from "../state/control";
import { make, setAttribute, setText } from "../ui/dom";
import { systemName } from "../ui/format";

const PATIENCE_MS = 10_000;

export interface AboardNeeds {
  readonly me: string;
  /** Names that people gave, by address. */
  readonly names: Readonly<Record<string, string>>;
  readonly path: string;
  /** The plan as it was saved; undefined while what is shown is not saved. */
  saved(): { readonly name: string; readonly revision: number; readonly digest: string } | undefined;
  pick(told: ((place: readonly [number, number]) => void) | null): void;
  mark(place: readonly [number, number] | null): void;
}

export interface Aboard {
  frame(frame: LiveFrame, systems: readonly System[], nowUs: number): void;
}

interface Vessel {
  readonly box: HTMLElement;
  readonly panel: ControlPanel;
  control: ControlState;
  /** The newest order after which the vessel's plans were looked at. */
  seen: number;
  plans: PlansAboard | undefined;
}

export function createAboard(root: HTMLElement, needs: AboardNeeds): Aboard {
  const choose = make("select", {}, make("option", { value: "" }, "choose a vessel"));
  const upload = make("button", { type: "button", class: "main" }, "Upload");
  const said = make("p", { class: "note bad", role: "alert", hidden: "" });
  const compared = make("p", { class: "compared", role: "status" });
  const place = make("div");
  root.append(make("h2", { id: "aboard-title" }, "To a vessel"), make("div", { class: "row" }, make("label", {}, "Vessel", choose), upload), said, compared, place);
  const vessels = new Map<number, Vessel>();
  let systems: readonly System[] = [];
  let listed = "";
  let controls: ReadonlyMap<number, ControlState> = new Map();

  const chosen = (): Vessel | undefined => vessels.get(Number(choose.value));
  const nameOf = (address: number): string => {
    const system = systems.find((one) => one.address === address);
    return needs.names[String(address)] ?? (system ? systemName(system) : String(address));
  };
  const fail = (text: string): void => {
    setText(said, text);
    setAttribute(said, "hidden", text ? null : "");
  };
  const vessel = (address: number): Vessel => {
    const known = vessels.get(address);
    if (known) return known;
    const box = make("div");
    const panel = createControl(box, { address, me: needs.me, may: true, name: () => nameOf(address), pick: needs.pick, mark: needs.mark });
    const made: Vessel = { box, panel, control: NO_CONTROL, seen: -1, plans: undefined };
    vessels.set(address, made);
    return made;
  };
  const look = async (address: number, one: Vessel): Promise<void> => {
    try {
      one.plans = await getJson<PlansAboard>(`/api/v1/vessels/${address}/plans`);
      compare();
    } catch (error) {
      fail(reason(error));
    }
  };
  /** Asks the vessel what it holds; what cannot be asked at present stays unknown, and is told as that. */
  const ask = (address: number, one: Vessel): void => {
    const known = (): Promise<void> => look(address, one);
    createOrders(address, windowKey()).ask({ kind: "plan.list" }).then(known, known);
  };
  const compare = (): void => {
    const [one, saved] = [chosen(), needs.saved()];
    const name = nameOf(Number(choose.value));
    upload.disabled = !one || !saved;
    upload.title = saved ? "" : "Save the plan first.";
    const copy = one?.plans?.plans.find((plan) => plan.plan_id === saved?.name);
    const state = !one ? "" : !saved ? "unsaved" : one.plans?.time_us == null ? "unknown" : !copy ? "absent" : copy.md5 === saved.digest ? "same" : "other";
    const short = saved?.digest.slice(0, 8) ?? "";
    const words: Readonly<Record<string, string>> = {
      "": "",
      unsaved: "What is shown is not saved: save it, then it can go aboard.",
      unknown: `Ashore ${short}. It is not known which plans are aboard ${name}: ask below.`,
      absent: `Ashore ${short}. ${name} has no plan of this name.`,
      same: `Same digest ashore and aboard ${name}: ${short}. It can be started below.`,
      other: `DIFFERENT: ashore ${short}, aboard ${name} ${copy?.md5.slice(0, 8) ?? ""}. Upload it to replace the vessel's.`,
    };
    setText(compared, words[state] ?? "");
    compared.dataset["copy"] = state;
  };
  choose.addEventListener("change", () => {
    fail("");
    const address = Number(choose.value);
    const one = address ? vessel(address) : undefined;
    place.replaceChildren(...(one ? [one.box] : []));
    if (one) ask(address, one);
    compare();
  });
  upload.addEventListener("click", () => {
    const [address, saved] = [Number(choose.value), needs.saved()];
    if (!address || !saved) return;
    fail("");
    const ask: PlanUploadAsk = { vessel: address, revision: saved.revision, window: windowKey() };
    postJson<Command>(`${needs.path}/upload`, PATIENCE_MS, ask).catch((error: unknown) => fail(`Not uploaded: ${reason(error)} The plan stays here as it is.`));
  });
  compare();

  return {
    frame(frame, now, nowUs) {
      systems = now;
      controls = withControls(controls, frame);
      const all = new Map(Object.entries(needs.names));
      for (const system of now) if (system.kind !== "CCU" && system.doors.some((door) => door !== "shore")) all.set(String(system.address), nameOf(system.address));
      const here = [...all].join("\n");
      if (here !== listed) {
        listed = here;
        const kept = choose.value;
        choose.replaceChildren(make("option", { value: "" }, "choose a vessel"), ...[...all].map(([address, name]) => make("option", { value: address }, name)));
        choose.value = kept;
      }
      for (const [address, one] of vessels) {
        one.control = controls.get(address) ?? NO_CONTROL;
        one.panel.update(one.control, now.find((system) => system.address === address), nowUs);
        const stored = one.control.commands.find((command) => command.over && /^plan\.(upload|delete|list)$/.test(command.order));
        if (stored && stored.id !== one.seen) {
          one.seen = stored.id;
          if (stored.order === "plan.list") void look(address, one);
          else ask(address, one);
        }
      }
      compare();
    },
  };
}
