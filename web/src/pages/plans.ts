// The list of plans: what there is, new ones, files in and out, and deleting with a way back.

import { deleteAt, getJson, postJson, reason } from "../api/http";
import type { ImportedPlan, PlanDocument, PlansAboard, PlanSummary, StoredPlan, System, VesselQuery, VesselQuerySent } from "../api/types.gen";
import { type Aboard, type Pair, pairs } from "../plan/copies";
import { durationText, energyText, lengthText } from "../plan/steps";
import { asCards } from "../ui/cards";
import { make, setAttribute } from "../ui/dom";
import { hexAddress, isShore, systemName, utc } from "../ui/format";
import { t, tn, withWords, worded } from "../words/words";

const PATIENCE_MS = 15_000;
/** How long a vessel's answer is waited for, and how often is looked whether it is there, ms. */
const ANSWER_MS = 5_000;
const LOOK_MS = 300;
/** Cells of a row before those of copies aboard. */
const BEFORE_COPIES = 5;
/** How a copy is told: never by colour alone. */
const COPIES: Readonly<Record<Pair["copies"][number]["copy"], string>> = { same: t("same"), differs: t("DIFFERS"), "only ashore": t("not aboard"), "only aboard": t("only aboard"), unknown: t("not known") };

export function startPlans(root: HTMLElement): void {
  new PlansPage(root);
}

class PlansPage {
  private readonly names: Readonly<Record<string, string>>;
  private readonly writable: boolean;
  private readonly told = make("div", { role: "status" });
  private readonly table = make("div", {}, make("p", { class: "dim" }, t("Loading …")));
  private readonly asked = make("p", { class: "dim", role: "status" });
  private readonly again = make("button", { type: "button" }, t("Compare with the vessels again"));
  private vessels: readonly Aboard[] = [];

  constructor(root: HTMLElement) {
    this.names = JSON.parse(root.dataset["vessels"] ?? "{}") as Record<string, string>;
    this.writable = root.dataset["operator"] !== undefined;
    this.again.addEventListener("click", () => void this.compare());
    if (this.writable) root.append(make("div", { class: "row plans-new" }, this.fresh(), make("label", {}, t("Import (GPX, GeoJSON, IMC JSON)"), this.file())));
    root.append(this.told, this.table, make("div", { class: "row" }, this.again, this.asked));
    void this.show().then(() => this.compare());
  }

  private say(kind: "good" | "warn" | "bad", text: string, ...more: Node[]): void {
    this.told.replaceChildren(make("div", { class: `note ${kind}` }, make("p", {}, text), ...more));
  }

  private async tried(what: string, work: () => Promise<void>): Promise<void> {
    try {
      await work();
    } catch (error) {
      this.say("bad", `${what}: ${reason(error)}`);
    }
  }

  private async show(): Promise<void> {
    try {
      const all = pairs(await getJson<PlanSummary[]>("/api/v1/plans"), this.vessels);
      this.table.replaceChildren(all.length ? this.tableOf(all) : this.empty());
    } catch (error) {
      this.table.replaceChildren(make("p", { class: "bad-text" }, reason(error)));
    }
  }

  /** Asks every vessel that is heard which plans it has; one that does not answer is told as that. */
  private async compare(): Promise<void> {
    const { again, asked } = this;
    again.disabled = true;
    try {
      const systems = (await getJson<System[]>("/api/v1/vessels")).filter((one) => one.kind !== "CCU" && !isShore(one) && (one.liveness === "live" || one.liveness === "late"));
      asked.textContent = systems.length ? t("Asking the vessels which plans they have …") : t("No vessel is heard: what is aboard is not known.");
      this.vessels = await Promise.all(systems.map(async (system) => ({ address: system.address, name: this.names[String(system.address)] ?? systemName(system), plans: await aboard(system.address) })));
      if (this.vessels.length) asked.textContent = answersOf(this.vessels);
    } catch (error) {
      asked.textContent = t("What is aboard is not known: {reason}", { reason: reason(error) });
    }
    again.disabled = false;
    await this.show();
  }

  private empty(): HTMLElement {
    const text = this.writable ? t("There are no plans yet. Press “New plan” and draw one on the map, or import one from GPX, GeoJSON or the JSON of an IMC PlanSpecification.") : t("There are no plans yet that you may see. An operator draws them here.");
    return make("div", { class: "card" }, make("p", {}, text));
  }

  private tableOf(all: readonly Pair[]): HTMLElement {
    const names = [t("Plan"), ...this.columns(), ...(this.writable ? [t("Actions")] : [])];
    const head = make("tr", {}, ...names.map((name) => make("th", { scope: "col" }, name)));
    return make("div", { class: "wide", tabindex: "0", role: "region", "aria-label": t("Plans") }, asCards(make("table", { class: "plans" }, make("thead", {}, head), make("tbody", {}, ...all.map((pair) => this.row(pair))))));
  }

  /** What stands between a plan's name and what can be done with it. */
  private columns(): string[] {
    return [t("Vessel"), t("State"), t("Changed"), t("Length, time, energy (estimates)"), t("Digest on the server"), ...this.vessels.map(({ name }) => t("Aboard {name}", { name }))];
  }

  private row({ name, ashore: plan, copies: all }: Pair): HTMLElement {
    const columns = this.columns();
    // On a phone, where no head stands above them, each cell shows the name of its column.
    const named = (cells: HTMLElement[], from: number): HTMLElement[] => {
      cells.forEach((cell, index) => setAttribute(cell, "data-name", columns[from + index] ?? ""));
      return cells;
    };
    const copies = named(all.map(({ copy, aboard }) => make("td", { "data-copy": copy }, make("span", {}, COPIES[copy], ...(aboard ? [" ", make("code", { title: `MD5 ${aboard.md5}` }, aboard.md5.slice(0, 8))] : [])))), BEFORE_COPIES);
    if (!plan) {
      const nobody = named(["—", t("only aboard"), "—", "—", "—"].map((text) => make("td", {}, text)), 0);
      return make("tr", {}, make("th", { scope: "row" }, name), ...nobody, ...copies, ...(this.writable ? [make("td", {})] : []));
    }
    const cells = named(this.cells(plan).map((cell, index) => make("td", index === 0 || index === 4 ? { class: "num" } : {}, cell)), 0);
    const acts = this.writable ? [make("td", {}, make("div", { class: "actions" }, this.duplicate(plan), this.away(plan)))] : [];
    return make("tr", {}, make("th", { scope: "row" }, make("a", { href: `/plans/${plan.id}` }, plan.name)), ...cells, ...copies, ...acts);
  }

  private cells(plan: PlanSummary): (Node | string)[] {
    return [
      plan.vessel === null ? t("any vessel") : (this.names[String(plan.vessel)] ?? hexAddress(plan.vessel)),
      plan.problems ? make("span", { class: "bad-text" }, tn(plan.problems, "1 problem", "{n} problems")) : plan.draft ? t("draft") : t("saved"),
      make("span", {}, make("time", { datetime: new Date(plan.updated_us / 1_000).toISOString() }, utc(plan.updated_us)), ` ${t("by {author}", { author: plan.author })}`),
      plan.problems ? "—" : [lengthText(plan.total.length_m), durationText(plan.total.duration_s), energyText(plan.total.energy_j)].join(" · "),
      plan.digest ? make("code", { title: `MD5 ${plan.digest}` }, plan.digest.slice(0, 8)) : "—",
    ];
  }

  private action(text: string, kind: string, { name }: PlanSummary, done: () => Promise<void>): HTMLElement {
    const made = make("button", { type: "button", class: kind, "aria-label": `${text} ${name}` }, text);
    made.addEventListener("click", () => void this.tried(`${text} ${name}`, done));
    return made;
  }

  private duplicate(plan: PlanSummary): HTMLElement {
    return this.action(t("Duplicate"), "", plan, async () => {
      const made = await postJson<StoredPlan>(`/api/v1/plans/${plan.id}/duplicate`, PATIENCE_MS);
      this.say("good", t("{copy} is a copy of {name}.", { copy: made.plan.name, name: plan.name }));
      await this.show();
    });
  }

  private away(plan: PlanSummary): HTMLElement {
    return this.action(t("Delete"), "danger", plan, async () => {
      await deleteAt(`/api/v1/plans/${plan.id}`, PATIENCE_MS);
      const back = make("button", { type: "button" }, t("Undo"));
      back.addEventListener("click", () => void this.tried(t("Undo of deleting {name}", { name: plan.name }), () => this.restore(plan)));
      this.say("warn", t("{name} was deleted.", { name: plan.name }), back);
      back.focus();
      await this.show();
    });
  }

  private async restore({ id }: PlanSummary): Promise<void> {
    const restored = await postJson<StoredPlan>(`/api/v1/plans/${id}/restore`, PATIENCE_MS);
    this.say("good", t("{name} is back.", { name: restored.plan.name }));
    await this.show();
  }

  private fresh(): HTMLElement {
    const button = make("button", { type: "button", class: "main" }, t("New plan"));
    button.addEventListener("click", () =>
      void this.tried(t("New plan"), async () => {
        const plan: PlanDocument = { name: "Plan", description: "", vessel: null, repeat: false, maneuvers: [] };
        const made = await postJson<StoredPlan>("/api/v1/plans", PATIENCE_MS, plan);
        location.assign(`/plans/${made.id}`);
      }),
    );
    return button;
  }

  private file(): HTMLElement {
    const input = make("input", { type: "file", accept: ".gpx,.geojson,.json", "aria-label": t("Import a plan from GPX, GeoJSON or IMC JSON") });
    input.addEventListener("change", () => {
      const [chosen] = input.files ?? [];
      if (chosen) void this.tried(t("Import"), () => this.import(chosen)).finally(() => (input.value = ""));
    });
    return input;
  }

  private async import(chosen: File): Promise<void> {
    const { stored, notes } = await postJson<ImportedPlan>(`/api/v1/plans/import?name=${encodeURIComponent(chosen.name)}`, PATIENCE_MS, chosen);
    await withWords(...notes.map(({ says }) => says));
    const open = make("a", { class: "button", href: `/plans/${stored.id}` }, t("Open {name}", { name: stored.plan.name }));
    const left = notes.length ? [make("ul", {}, ...notes.slice(0, 20).map((note) => make("li", {}, worded(note))))] : [];
    this.say(notes.length ? "warn" : "good", tn(stored.plan.maneuvers.length, "{file} is imported as {name}, {n} maneuver.", "{file} is imported as {name}, {n} maneuvers.", { file: chosen.name, name: stored.plan.name }), ...left, open);
    await this.show();
  }
}

/** Who told, and who did not. */
function answersOf(vessels: readonly Aboard[]): string {
  const silent = vessels.filter(({ plans }) => !plans).map(({ name }) => name);
  return silent.length ? t("No answer from {silent}.", { silent: silent.join(", ") }) : t("Reported by the vessels {time}.", { time: utc(Math.min(...vessels.map(({ plans }) => plans?.time_us ?? 0))) });
}

/** The plans aboard a vessel as it tells them now; undefined where it does not answer. */
async function aboard(address: number): Promise<PlansAboard | undefined> {
  const path = `/api/v1/vessels/${address}`;
  const ask = (): Promise<VesselQuerySent> => postJson<VesselQuerySent>(`${path}/ask`, PATIENCE_MS, { about: "plans" } satisfies VesselQuery);
  const first = await ask();
  let { packets } = first;
  const end = performance.now() + ANSWER_MS;
  for (;;) {
    const plans = await getJson<PlansAboard>(`${path}/plans`);
    if (plans.time_us !== null && plans.time_us >= first.time_us) return plans;
    if (performance.now() > end) return undefined;
    await new Promise((done) => setTimeout(done, LOOK_MS));
    // Who asked a moment ago may have been told what is not true any more.
    if (!packets) ({ packets } = await ask());
  }
}
