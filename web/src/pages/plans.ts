// The list of plans: what there is, new ones, files in and out, and deleting with a way back.

import { deleteAt, getJson, postJson, reason } from "../api/http";
import type { ImportedPlan, PlanDocument, PlansAboard, PlanSummary, StoredPlan, System, VesselAsk, VesselAsked } from "../api/types.gen";
import { type Aboard, type Pair, pairs } from "../plan/copies";
import { durationText, energyText, lengthText } from "../plan/steps";
import { make } from "../ui/dom";
import { hexAddress, isShore, systemName, utc } from "../ui/format";

const PATIENCE_MS = 15_000;
/** How long a vessel's answer is waited for, and how often is looked whether it is there, ms. */
const ANSWER_MS = 5_000;
const LOOK_MS = 300;
/** How a copy is told: never by colour alone. */
const COPIES: Readonly<Record<Pair["copies"][number]["copy"], string>> = { same: "same", differs: "DIFFERS", "only ashore": "not aboard", "only aboard": "only aboard", unknown: "not known" };

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
  let vessels: readonly Aboard[] = [];
  const show = async (): Promise<void> => {
    try {
      const all = pairs(await getJson<PlanSummary[]>("/api/v1/plans"), vessels);
      table.replaceChildren(all.length ? tableOf(all) : empty());
    } catch (error) {
      table.replaceChildren(make("p", { class: "bad-text" }, reason(error)));
    }
  };
  /** Asks every vessel that is heard which plans it has; one that does not answer is told as that. */
  const compare = async (): Promise<void> => {
    again.disabled = true;
    try {
      const systems = (await getJson<System[]>("/api/v1/vessels")).filter((one) => one.kind !== "CCU" && !isShore(one) && (one.liveness === "live" || one.liveness === "late"));
      asked.textContent = systems.length ? "Asking the vessels which plans they have …" : "No vessel is heard: what is aboard is not known.";
      vessels = await Promise.all(systems.map(async (system) => ({ address: system.address, name: names[String(system.address)] ?? systemName(system), plans: await aboard(system.address) })));
      const silent = vessels.filter(({ plans }) => !plans).map(({ name }) => name);
      asked.textContent = !vessels.length ? asked.textContent : silent.length ? `No answer from ${silent.join(", ")}.` : `As the vessels told ${utc(Math.min(...vessels.map(({ plans }) => plans?.time_us ?? 0)))}.`;
    } catch (error) {
      asked.textContent = `What is aboard is not known: ${reason(error)}`;
    }
    again.disabled = false;
    await show();
  };
  const aboard = async (address: number): Promise<PlansAboard | undefined> => {
    const path = `/api/v1/vessels/${address}`;
    const ask = (): Promise<VesselAsked> => postJson<VesselAsked>(`${path}/ask`, PATIENCE_MS, { about: "plans" } satisfies VesselAsk);
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
  };
  const asked = make("p", { class: "dim", role: "status" });
  const again = make("button", { type: "button" }, "Compare with the vessels again");
  again.addEventListener("click", () => void compare());

  const empty = (): HTMLElement =>
    make(
      "div",
      { class: "card" },
      make("p", {}, writable ? "There are no plans yet. Press “New plan” and draw one on the map, or import one from GPX, GeoJSON or the JSON of an IMC PlanSpecification." : "There are no plans yet that you may see. An operator draws them here."),
    );

  const tableOf = (all: readonly Pair[]): HTMLElement => {
    const head = make("tr");
    for (const name of ["Plan", "For", "State", "Changed", "Takes (energy estimated)", "Digest ashore", ...vessels.map(({ name }) => `Aboard ${name}`), ...(writable ? ["Do"] : [])]) head.append(make("th", { scope: "col" }, name));
    const rows = all.map((pair) => {
      const { ashore: plan } = pair;
      const copies = pair.copies.map(({ copy, aboard }) =>
        make("td", { "data-copy": copy }, COPIES[copy], ...(aboard ? [" ", make("code", { title: `MD5 ${aboard.md5}` }, aboard.md5.slice(0, 8))] : [])),
      );
      if (!plan) {
        const nobody = ["—", "only aboard", "—", "—", "—"].map((text) => make("td", {}, text));
        return make("tr", {}, make("th", { scope: "row" }, pair.name), ...nobody, ...copies, ...(writable ? [make("td", {})] : []));
      }
      const cells: (Node | string)[] = [
        plan.vessel === null ? "any vessel" : (names[String(plan.vessel)] ?? hexAddress(plan.vessel)),
        plan.problems ? make("span", { class: "bad-text" }, plan.problems === 1 ? "1 problem" : `${plan.problems} problems`) : plan.draft ? "draft" : "saved",
        `${utc(plan.updated_us)} by ${plan.author}`,
        plan.problems ? "—" : [lengthText(plan.total.length_m), durationText(plan.total.duration_s), energyText(plan.total.energy_j)].join(" · "),
        plan.digest ? make("code", { title: `MD5 ${plan.digest}` }, plan.digest.slice(0, 8)) : "—",
      ];
      const row = make("tr", {}, make("th", { scope: "row" }, make("a", { href: `/plans/${plan.id}` }, plan.name)), ...cells.map((cell, index) => make("td", index === 4 ? { class: "num" } : {}, cell)), ...copies);
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
  root.append(told, table, make("div", { class: "row" }, again, asked));
  void show().then(compare);
}
