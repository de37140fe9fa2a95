// Bringing a plan aboard: which vessel, whether its copy is the shore's, and the vessel's control beside it.

import { getJson, postJson, reason } from "../api/http";
import type { Command, LiveFrame, PlanAboard, PlanDocument, PlansAboard, PlanUploadRequest, System } from "../api/types.gen";
import { type ControlPanel, createControl } from "../control/panel";
import { createOrders, windowKey } from "../control/orders";
import { type ControlState, NO_CONTROL, withControls } from "../state/control";
import type { RefusedOnMap } from "../map/danger";
import { make, setText } from "../ui/dom";
import { systemName } from "../ui/format";
import { t } from "../words/words";

const PATIENCE_MS = 10_000;

export interface AboardNeeds {
  readonly me: string;
  /** Names that people gave, by address. */
  readonly names: Readonly<Record<string, string>>;
  readonly path: string;
  /** The plan as it was saved; undefined while what is shown is not saved. */
  saved(): { readonly name: string; readonly revision: number; readonly digest: string; readonly plan: PlanDocument } | undefined;
  pick(told: ((place: readonly [number, number]) => void) | null): void;
  mark(place: readonly [number, number] | null): void;
  readonly refusedOnMap: RefusedOnMap;
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
  unsaved: t("Not saved"),
  unknown: t("Unknown what is aboard"),
  absent: t("Not aboard"),
  same: t("Same aboard"),
  other: t("Another copy aboard"),
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
  return new ToVessel(root, needs);
}

class ToVessel implements Aboard {
  private readonly choose = make("select", {}, make("option", { value: "" }, t("choose a vessel")));
  private readonly compared = make("p", { class: "compared", role: "status" });
  private readonly place = make("div");
  private readonly vessels = new Map<number, Vessel>();
  private systems: readonly System[] = [];
  private listed = "";
  private controls: ReadonlyMap<number, ControlState> = new Map();
  private preferred: number | null = null;
  private byHand = false;
  private said = "";
  private standing: Standing = "";

  constructor(root: HTMLElement, private readonly needs: AboardNeeds) {
    root.append(make("h2", { id: "aboard-title" }, t("To a vessel")), make("div", { class: "row" }, make("label", {}, t("Vessel"), this.choose)), this.compared, this.place);
    this.choose.addEventListener("change", () => {
      this.byHand = true;
      this.fail("");
      const one = this.shown();
      if (one) this.ask(this.address, one);
      this.compare();
    });
    this.compare();
  }

  prefer(address: number | null): void {
    this.preferred = address;
    this.takePreferred();
  }

  chosen(): { readonly address: number; readonly name: string } | undefined {
    return this.choose.value ? { address: this.address, name: this.nameOf(this.address) } : undefined;
  }

  now(): AboardNow {
    const { standing, said } = this;
    const holds = this.vessel?.panel.holds() === true;
    const text = standing === "same" && !holds ? t("{same}, no control", { same: SHORT.same }) : this.needs.saved() ? SHORT[standing] : SHORT.unsaved;
    return { text, said, mayUpload: standing !== "" && standing !== "unsaved", mayStart: standing === "same" && holds, whyNot: this.whyNot() };
  }

  upload(): void {
    const [address, saved, panel] = [this.address, this.needs.saved(), this.vessel?.panel];
    if (!address || !saved) return;
    this.fail("");
    const ask: PlanUploadRequest = { vessel: address, revision: saved.revision, window: windowKey() };
    postJson<Command>(`${this.needs.path}/upload`, PATIENCE_MS, ask).then(
      (command) => panel?.given(command),
      (error: unknown) => {
        this.fail(t("Not uploaded: {why} The plan stays here as it is.", { why: reason(error).replace(/\.?$/, ".") }));
        panel?.refused(error);
      },
    );
  }

  start(): void {
    const copy = this.copyOf(this.vessel);
    if (copy && this.standing === "same") this.vessel?.panel.start(copy);
  }

  focus(): void {
    this.choose.focus();
  }

  frame(frame: LiveFrame, now: readonly System[], nowUs: number): void {
    this.systems = now;
    this.controls = withControls(this.controls, frame);
    this.list();
    for (const [address, one] of this.vessels) this.bring(address, one, nowUs);
    this.compare();
  }

  /** Fills the choice, where others are there than before. */
  private list(): void {
    const all = new Map(Object.entries(this.needs.names));
    for (const system of this.systems) if (system.kind !== "CCU" && system.transports.some((transport) => transport !== "shore")) all.set(String(system.address), this.nameOf(system.address));
    const here = [...all].join("\n");
    if (here === this.listed) return;
    this.listed = here;
    const kept = this.choose.value;
    this.choose.replaceChildren(make("option", { value: "" }, t("choose a vessel")), ...[...all].map(([address, name]) => make("option", { value: address }, name)));
    this.choose.value = kept;
    this.takePreferred();
  }

  /** Brings a vessel's control up to date, and looks at its plans after each order that may have changed them. */
  private bring(address: number, one: Vessel, nowUs: number): void {
    one.control = this.controls.get(address) ?? NO_CONTROL;
    one.panel.update(one.control, this.systems.find((system) => system.address === address), nowUs);
    const stored = one.control.commands.find((command) => command.over && /^plan\.(upload|delete|list)$/.test(command.order));
    if (!stored || stored.id === one.seen) return;
    one.seen = stored.id;
    if (stored.order === "plan.list") void this.look(address, one);
    else this.ask(address, one);
  }

  private get address(): number {
    return Number(this.choose.value);
  }

  /** The one that is chosen. */
  private get vessel(): Vessel | undefined {
    return this.vessels.get(this.address);
  }

  private nameOf(address: number): string {
    const system = this.systems.find((one) => one.address === address);
    return this.needs.names[String(address)] ?? (system ? systemName(system) : String(address));
  }

  private fail(text: string): void {
    this.said = text;
    this.needs.told();
  }

  private made(address: number): Vessel {
    const known = this.vessels.get(address);
    if (known) return known;
    const { me, pick, mark, refusedOnMap } = this.needs;
    const box = make("div");
    const panel = createControl(box, { address, me, may: true, name: () => this.nameOf(address), pick, mark, refusedOnMap });
    const made: Vessel = { box, panel, control: NO_CONTROL, seen: -1, plans: undefined };
    this.vessels.set(address, made);
    return made;
  }

  private shown(): Vessel | undefined {
    const one = this.address ? this.made(this.address) : undefined;
    this.place.replaceChildren(...(one ? [one.box] : []));
    return one;
  }

  private async look(address: number, one: Vessel): Promise<void> {
    try {
      one.plans = await getJson<PlansAboard>(`/api/v1/vessels/${address}/plans`);
      this.compare();
    } catch (error) {
      this.fail(reason(error));
    }
  }

  /** Asks the vessel what it holds; what cannot be asked at present stays unknown, and is told as that. */
  private ask(address: number, one: Vessel): void {
    const known = (): Promise<void> => this.look(address, one);
    createOrders(address, windowKey()).ask({ kind: "plan.list" }).then(known, known);
  }

  /** Chooses the vessel that the plan is for, and only looks at what it told before: nobody asked for more yet. */
  private takePreferred(): void {
    const { choose, preferred } = this;
    const wanted = String(preferred ?? "");
    if (this.byHand || choose.value === wanted || ![...choose.options].some(({ value }) => value === wanted)) return;
    choose.value = wanted;
    const one = this.shown();
    if (one && preferred !== null) void this.look(preferred, one);
    this.compare();
  }

  private copyOf(one: Vessel | undefined): PlanAboard | undefined {
    return one?.plans?.plans.find((plan) => plan.plan_id === this.needs.saved()?.name);
  }

  private compare(): void {
    const [one, saved] = [this.vessel, this.needs.saved()];
    const copy = this.copyOf(one);
    this.standing = !one ? "" : !saved ? "unsaved" : one.plans?.time_us == null ? "unknown" : !copy ? "absent" : copy.md5 === saved.digest ? "same" : "other";
    setText(this.compared, comparedText(this.standing, this.nameOf(this.address), saved?.digest.slice(0, 8) ?? "", copy?.md5.slice(0, 8) ?? ""));
    this.compared.dataset["copy"] = this.standing;
    this.needs.told();
  }

  private whyNot(): string {
    if (this.standing === "") return t("Choose a vessel first.");
    if (this.standing === "unsaved") return t("Save the plan first.");
    if (this.standing !== "same") return t("Upload the plan first.");
    return this.vessel?.panel.holds() ? "" : t("Take control first.");
  }
}

/** How the copies stand to each other, with the first digits of their digests. */
function comparedText(standing: Standing, name: string, short: string, md5: string): string {
  const words: Readonly<Record<Standing, string>> = {
    "": "",
    unsaved: t("What is shown is not saved: save it, then it can go aboard."),
    unknown: t("Ashore {short}. It is not known which plans are aboard {name}: ask below.", { short, name }),
    absent: t("Ashore {short}. {name} has no plan of this name.", { short, name }),
    same: t("Same digest ashore and aboard {name}: {short}. It can be started below.", { name, short }),
    other: t("DIFFERENT: ashore {short}, aboard {name} {md5}. Upload it to replace the vessel's.", { short, name, md5 }),
  };
  return words[standing];
}
