// Bringing a plan aboard: which vessel, whether its copy is the shore's, and the vessel's control beside it.

import { getJson, postJson, reason } from "../api/http";
import type { Command, LiveFrame, PlansAboard, PlanUploadAsk, System } from "../api/types.gen";
import { type ControlPanel, createControl } from "../control/panel";
import { createOrders, windowKey } from "../control/orders";
import { type ControlState, NO_CONTROL, withControls } from "../state/control";
import { make, setText } from "../ui/dom";
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
  /** What can be done, or was said, is another. */
  told(): void;
}

export interface Aboard {
  frame(frame: LiveFrame, systems: readonly System[], nowUs: number): void;
  /** The vessel that the plan is for; chosen until somebody chooses another. */
  prefer(address: number | null): void;
  /** The chosen vessel. */
  chosen(): { readonly address: number; readonly name: string } | undefined;
  /** How the plan stands aboard, in a few words, and what may be done. */
  now(): AboardNow;
  upload(): void;
  /** Asks whether it shall be started. */
  start(): void;
  /** Puts the keyboard onto the choice of the vessel. */
  focus(): void;
}

export interface AboardNow {
  readonly text: string;
  readonly mayUpload: boolean;
  readonly mayStart: boolean;
  readonly whyNot: string;
  /** Why the last upload failed; empty for nothing. */
  readonly said: string;
}

/** How the vessel's copy is to what was saved. */
type Standing = "" | "unsaved" | "unknown" | "absent" | "same" | "other";

const SHORT: Readonly<Record<Standing, string>> = {
  "": "",
  unsaved: "Not saved",
  unknown: "Not known what is aboard",
  absent: "Not aboard",
  same: "Same aboard",
  other: "Another copy aboard",
};

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
  const compared = make("p", { class: "compared", role: "status" });
  const place = make("div");
  root.append(make("h2", { id: "aboard-title" }, "To a vessel"), make("div", { class: "row" }, make("label", {}, "Vessel", choose)), compared, place);
  const vessels = new Map<number, Vessel>();
  let systems: readonly System[] = [];
  let listed = "";
  let controls: ReadonlyMap<number, ControlState> = new Map();
  let preferred: number | null = null;
  let byHand = false;
  let said = "";
  let standing: Standing = "";

  const chosen = (): Vessel | undefined => vessels.get(Number(choose.value));
  const nameOf = (address: number): string => {
    const system = systems.find((one) => one.address === address);
    return needs.names[String(address)] ?? (system ? systemName(system) : String(address));
  };
  const fail = (text: string): void => {
    said = text;
    needs.told();
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
    const copy = copyOf(one);
    const state: Standing = !one ? "" : !saved ? "unsaved" : one.plans?.time_us == null ? "unknown" : !copy ? "absent" : copy.md5 === saved.digest ? "same" : "other";
    const short = saved?.digest.slice(0, 8) ?? "";
    const words: Readonly<Record<Standing, string>> = {
      "": "",
      unsaved: "What is shown is not saved: save it, then it can go aboard.",
      unknown: `Ashore ${short}. It is not known which plans are aboard ${name}: ask below.`,
      absent: `Ashore ${short}. ${name} has no plan of this name.`,
      same: `Same digest ashore and aboard ${name}: ${short}. It can be started below.`,
      other: `DIFFERENT: ashore ${short}, aboard ${name} ${copy?.md5.slice(0, 8) ?? ""}. Upload it to replace the vessel's.`,
    };
    setText(compared, words[state]);
    compared.dataset["copy"] = state;
    standing = state;
    needs.told();
  };
  const copyOf = (one: Vessel | undefined) => one?.plans?.plans.find((plan) => plan.plan_id === needs.saved()?.name);
  const shown = (): Vessel | undefined => {
    const address = Number(choose.value);
    const one = address ? vessel(address) : undefined;
    place.replaceChildren(...(one ? [one.box] : []));
    return one;
  };
  choose.addEventListener("change", () => {
    byHand = true;
    fail("");
    const one = shown();
    if (one) ask(Number(choose.value), one);
    compare();
  });
  /** Chooses the vessel that the plan is for, and only looks at what it told before: nobody asked for more yet. */
  const takePreferred = (): void => {
    const wanted = String(preferred ?? "");
    if (byHand || choose.value === wanted || ![...choose.options].some(({ value }) => value === wanted)) return;
    choose.value = wanted;
    const one = shown();
    if (one && preferred !== null) void look(preferred, one);
    compare();
  };
  const whyNot = (): string => {
    if (standing === "") return "Choose a vessel first.";
    if (standing === "unsaved") return "Save the plan first.";
    if (standing !== "same") return "Upload the plan first.";
    return chosen()?.panel.holds() ? "" : "Take control first.";
  };
  compare();

  return {
    prefer(address) {
      preferred = address;
      takePreferred();
    },
    chosen: () => (choose.value ? { address: Number(choose.value), name: nameOf(Number(choose.value)) } : undefined),
    now() {
      const holds = chosen()?.panel.holds() === true;
      const text = standing === "same" && !holds ? `${SHORT.same}, no control` : needs.saved() ? SHORT[standing] : SHORT.unsaved;
      return { text, said, mayUpload: standing !== "" && standing !== "unsaved", mayStart: standing === "same" && holds, whyNot: whyNot() };
    },
    upload() {
      const [address, saved] = [Number(choose.value), needs.saved()];
      if (!address || !saved) return;
      fail("");
      const ask: PlanUploadAsk = { vessel: address, revision: saved.revision, window: windowKey() };
      postJson<Command>(`${needs.path}/upload`, PATIENCE_MS, ask).catch((error: unknown) => fail(`Not uploaded: ${reason(error).replace(/\.?$/, ".")} The plan stays here as it is.`));
    },
    start() {
      const copy = copyOf(chosen());
      if (copy && standing === "same") chosen()?.panel.start(copy);
    },
    focus: () => choose.focus(),
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
        takePreferred();
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
