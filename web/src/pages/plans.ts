// The list of plans: what there is, new ones, files in and out, and deleting with a way back.

import { deleteAt, getJson, postJson, reason } from "../api/http";
import type { ImportedPlan, PlanDocument, PlanSummary, StoredPlan } from "../api/types.gen";
import { durationText, energyText, lengthText } from "../plan/steps";
import { make } from "../ui/dom";
import { utc } from "../ui/format";

const PATIENCE_MS = 15_000;

export function startPlans(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["vessels"] ?? "{}") as Record<string, string>;
  const writable = root.dataset["operator"] !== undefined;
  const told = make("div", { role: "status" });
  const table = make("div", {}, make("p", { class: "dim" }, "Loading …"));

  const say = (kind: "good" | "warn" | "bad", text: string, ...more: Node[]): void => {
    told.replaceChildren(make("div", { class: `note ${kind}` }, make("p", {}, text), ...more));
  };
  const tried = async (what: string, work: () => Promise<void>): Promise<void> => {
    try {
      await work();
    } catch (error) {
      say("bad", `${what}: ${reason(error)}`);
    }
  };
  const show = async (): Promise<void> => {
    try {
      const plans = await getJson<PlanSummary[]>("/api/v1/plans");
      table.replaceChildren(plans.length ? tableOf(plans) : empty());
    } catch (error) {
      table.replaceChildren(make("p", { class: "bad-text" }, reason(error)));
    }
  };

  const empty = (): HTMLElement =>
    make(
      "div",
      { class: "card" },
      make("p", {}, writable ? "There are no plans yet. Press “New plan” and draw one on the map, or import one from GPX, GeoJSON or the JSON of an IMC PlanSpecification." : "There are no plans yet that you may see. An operator draws them here."),
    );

  const tableOf = (plans: readonly PlanSummary[]): HTMLElement => {
    const head = make("tr");
    for (const name of ["Plan", "For", "State", "Changed", "Takes (energy estimated)", "Digest ashore", ...(writable ? ["Do"] : [])]) head.append(make("th", { scope: "col" }, name));
    const rows = plans.map((plan) => {
      const cells: (Node | string)[] = [
        plan.vessel === null ? "any vessel" : (names[String(plan.vessel)] ?? `0x${plan.vessel.toString(16).toUpperCase().padStart(4, "0")}`),
        plan.problems ? make("span", { class: "bad-text" }, plan.problems === 1 ? "1 problem" : `${plan.problems} problems`) : plan.draft ? "draft" : "saved",
        `${utc(plan.updated_us)} by ${plan.author}`,
        plan.problems ? "—" : [lengthText(plan.total.length_m), durationText(plan.total.duration_s), energyText(plan.total.energy_j)].join(" · "),
        plan.digest ? make("code", { title: `MD5 ${plan.digest}` }, plan.digest.slice(0, 8)) : "—",
      ];
      const row = make("tr", {}, make("th", { scope: "row" }, make("a", { href: `/plans/${plan.id}` }, plan.name)), ...cells.map((cell, index) => make("td", index === 4 ? { class: "num" } : {}, cell)));
      if (writable) row.append(make("td", {}, make("div", { class: "actions" }, ...actions(plan))));
      return row;
    });
    return make("div", { class: "wide", tabindex: "0", role: "region", "aria-label": "Plans" }, make("table", { class: "plans" }, make("thead", {}, head), make("tbody", {}, ...rows)));
  };

  const actions = (plan: PlanSummary): HTMLElement[] => {
    const button = (text: string, kind: string, done: () => Promise<void>): HTMLElement => {
      const made = make("button", { type: "button", class: kind, "aria-label": `${text} ${plan.name}` }, text);
      made.addEventListener("click", () => void tried(`${text} ${plan.name}`, done));
      return made;
    };
    const path = `/api/v1/plans/${plan.id}`;
    const copy = button("Duplicate", "", async () => {
      const made = await postJson<StoredPlan>(`${path}/duplicate`, PATIENCE_MS);
      say("good", `${made.plan.name} is a copy of ${plan.name}.`);
      await show();
    });
    const away = button("Delete", "danger", async () => {
      await deleteAt(path, PATIENCE_MS);
      const back = make("button", { type: "button" }, "Undo");
      back.addEventListener("click", () =>
        void tried(`Undo of deleting ${plan.name}`, async () => {
          const restored = await postJson<StoredPlan>(`${path}/restore`, PATIENCE_MS);
          say("good", `${restored.plan.name} is back.`);
          await show();
        }),
      );
      say("warn", `${plan.name} was deleted.`, back);
      back.focus();
      await show();
    });
    return [copy, away];
  };

  if (writable) {
    const fresh = make("button", { type: "button", class: "main" }, "New plan");
    fresh.addEventListener("click", () =>
      void tried("New plan", async () => {
        const plan: PlanDocument = { name: "Plan", description: "", vessel: null, repeat: false, maneuvers: [] };
        const made = await postJson<StoredPlan>("/api/v1/plans", PATIENCE_MS, plan);
        location.assign(`/plans/${made.id}`);
      }),
    );
    const file = make("input", { type: "file", accept: ".gpx,.geojson,.json", "aria-label": "Import a plan from GPX, GeoJSON or IMC JSON" });
    file.addEventListener("change", () => {
      const [chosen] = file.files ?? [];
      if (!chosen) return;
      void tried("Import", async () => {
        const { stored, notes } = await postJson<ImportedPlan>(`/api/v1/plans/import?name=${encodeURIComponent(chosen.name)}`, PATIENCE_MS, chosen);
        const open = make("a", { class: "button", href: `/plans/${stored.id}` }, `Open ${stored.plan.name}`);
        const left = notes.length ? [make("ul", {}, ...notes.slice(0, 20).map((note) => make("li", {}, note)))] : [];
        say(notes.length ? "warn" : "good", `${chosen.name} is imported as ${stored.plan.name}, ${stored.plan.maneuvers.length} maneuvers.`, ...left, open);
        await show();
      }).finally(() => (file.value = ""));
    });
    root.append(make("div", { class: "row plans-new" }, fresh, make("label", {}, "Import (GPX, GeoJSON, IMC JSON)", file)));
  }
  root.append(told, table);
  void show();
}
