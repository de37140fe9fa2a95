// The editor of one plan: map, maneuvers, what they take, and how it is kept.

import { getJson, postJson, reason, Refusal } from "../api/http";
import type { PlanCheck, PlanDocument, PlanPlace, PlanSpeed, SpeedUnit, StoredPlan, System } from "../api/types.gen";
import { createMap } from "../map/map";
import { createAboard } from "../plan/aboard";
import { createCanvas } from "../plan/canvas";
import { checkField, choiceField, numberField, rebuilt, textField } from "../plan/fields";
import { createProfile } from "../plan/profile";
import { createVerdict } from "../plan/verdict";
import { createKeeper, forget, type Keeper, type Keeping, type Left, leftovers } from "../plan/keeper";
import { createSteps, durationText, energyText, lengthText, UNITS } from "../plan/steps";
import { displaced, History, KINDS, middle, placeAt, placesOf, same, type TaskKind, type Vertex, vertices, withBetween, withName, withNew, withOrder, withoutStep, withoutVertex, withPlace, withPoint, withSpeed, withTask, wayOfAll } from "../state/plan";
import { asSeen, EMPTY, serverNowUs } from "../state/fleet";
import { createChrome } from "../ui/chrome";
import { make, setAttribute, setText } from "../ui/dom";
import { hexAddress, utc } from "../ui/format";

/** What is drawn is judged this long after the last change, ms. */
const CHECK_MS = 200;
const PATIENCE_MS = 10_000;
/** Vessels are drawn anew at least so often, for they grow old, ms. */
const VESSELS_MS = 500;
/** The depth beside the plan is looked at this far, m. */
const BESIDE_M = 5;
/** Arrow keys move a vertex by this; with Shift by ten times as much, m. */
const NUDGE_M = 1;
const MINUTES_KEY = "lutra.minutes";

export function startPlan(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["vessels"] ?? "{}") as Record<string, string>;
  const path = `/api/v1/plans/${Number(root.dataset["id"])}`;
  void getJson<StoredPlan>(path).then(
    (stored) => edit(root, stored, path, names),
    (error: unknown) => {
      createChrome({ messages: ["VehicleState"], events: false, every_ms: 500 }, {});
      root.append(make("p", { class: "note bad", role: "alert" }, reason(error), " ", make("a", { href: "/plans" }, "All plans")));
    },
  );
}

function edit(root: HTMLElement, first: StoredPlan, path: string, names: Readonly<Record<string, string>>): void {
  const writable = root.dataset["operator"] !== undefined;
  const history = new History(first.plan);
  let selected: Vertex | undefined;
  let tool: TaskKind | undefined;
  let check = first.check;
  let minutes = localStorage.getItem(MINUTES_KEY) === "yes";
  let dragged: PlanDocument | undefined;
  let systems: readonly System[] = [];
  let judgedWith: string | null | undefined;

  const mapBox = make("div", { class: "map", tabindex: "0", role: "application", "aria-label": "Map of the plan. Arrow keys move the chosen place by a metre, with Shift by ten; without one they move the map. Delete takes it away, Escape lets go. The list of maneuvers does the same." });
  const tools = make("div", { class: "tools", role: "toolbar", "aria-label": "Tools" });
  const head = make("section", { class: "plan-head", "aria-label": "Plan" });
  const status = make("p", { class: "keeping", role: "status" });
  const offers = make("div", { class: "offers" });
  const totals = make("p", { class: "totals num", role: "status", "aria-label": "What the plan takes" });
  const troubles = make("div", { class: "troubles", role: "status" });
  const depths = make("section", { class: "plan-profile plot", "aria-labelledby": "profile-title", hidden: "" });
  const list = make("section", { class: "plan-list", "aria-label": "List of maneuvers" });
  const form = make("section", { class: "plan-form", "aria-labelledby": "step-title", hidden: "" });
  const ship = make("section", { class: "plan-aboard", "aria-labelledby": "aboard-title" });
  const side = make("div", { class: "plan-side" }, head, offers, status, totals, troubles, list, form, depths, ...(writable ? [ship] : []));
  root.append(make("div", { class: "plan-main" }, tools, make("div", { class: "map-box" }, mapBox)), side);

  const plan = (): PlanDocument => dragged ?? history.plan;
  const defaultSpeed = (): PlanSpeed => history.plan.maneuvers.at(-1)?.speed ?? { value: 1.5, unit: "mps" };

  const map = createMap(mapBox, { showAll: () => canvas.fit() });
  const canvas = createCanvas(map, {
    draws: () => tool !== undefined,
    clicked(place) {
      if (!writable || !tool) {
        selected = undefined;
        draw();
        return;
      }
      add(tool, place);
    },
    select(vertex) {
      select(vertex);
    },
    moved(vertex, place, done) {
      if (!writable) return;
      const next = withPlace(history.plan, vertex, place);
      dragged = done ? undefined : next;
      if (done) change(next);
      else {
        canvas.update(next, selected, check.maneuvers);
        askCheck();
      }
    },
    between(after, place) {
      if (!writable) return after;
      const { plan: next, vertex } = withBetween(history.plan, after, place);
      selected = vertex;
      change(next);
      return vertex;
    },
  });
  const verdict = createVerdict(map);
  const profile = createProfile(depths, BESIDE_M, (place) => map.overlays.cursor(place));
  map.onRepaint(() => profile.repaint());
  map.chart.onChart((chart) => {
    profile.limits(chart.set === null ? undefined : chart);
    // What was judged without a chart, or with another one, is judged anew.
    if (judgedWith !== undefined && judgedWith !== chart.set) askCheck();
    judgedWith = chart.set;
  });

  const steps = createSteps(list, form, {
    select,
    name: (step, id) => change(withName(history.plan, step, id)),
    speed: (step, speed) => change(withSpeed(history.plan, speed, step)),
    place(vertex, place) {
      selected = vertex;
      change(withPlace(history.plan, vertex, place));
      canvas.reveal(place);
    },
    values: (step, values) => change(withTask(history.plan, step, values)),
    order(step, by) {
      if (selected?.step === step) selected = { ...selected, step: step + by };
      else if (selected?.step === step + by) selected = { ...selected, step };
      const next = withOrder(history.plan, step, by);
      if (next === history.plan && selected) selected = { ...selected, step };
      change(next);
    },
    remove,
    insert(after) {
      const made = withBetween(history.plan, after, placeAfter(after));
      selected = made.vertex;
      change(made.plan);
    },
    insertPoint(after) {
      selected = { step: after.step, point: after.point + 1 };
      change(withPoint(history.plan, selected, placeAfter(after)));
    },
  });

  /** Half way to the next place, or a little to the north of the last. */
  function placeAfter(after: Vertex): PlanPlace {
    const all = vertices(history.plan);
    const at = all.findIndex(({ vertex }) => vertex.step === after.step && vertex.point === after.point);
    const [here, next] = [all[at]?.place ?? canvas.centre(), all[at + 1]?.place];
    return next ? middle(here, next) : displaced(here, 50, 0);
  }

  function select(vertex: Vertex): void {
    selected = vertex;
    const place = placeAt(history.plan, vertex);
    if (place) canvas.reveal(place);
    draw();
  }

  function add(kind: TaskKind, place: PlanPlace): void {
    const now = history.plan;
    const open = selected ? now.maneuvers[selected.step] : undefined;
    if (kind === "follow_path" && selected && open?.task.kind === "follow_path") {
      selected = { step: selected.step, point: selected.point + 1 };
      change(withPoint(now, selected, place));
      return;
    }
    const at = selected ? selected.step + 1 : now.maneuvers.length;
    selected = { step: at, point: 0 };
    change(withNew(now, kind, place, defaultSpeed(), at));
  }

  function remove(vertex: Vertex, whole: boolean): void {
    const next = whole ? withoutStep(history.plan, vertex.step) : withoutVertex(history.plan, vertex);
    const left = next.maneuvers.length;
    const step = Math.min(vertex.step, left - 1);
    const points = left ? placesOf(next.maneuvers[step]!.task).length : 0;
    selected = left ? { step, point: whole ? 0 : Math.min(vertex.point, points - 1) } : undefined;
    change(next);
    if (whole) steps.focus();
  }

  /** The plan as it was saved last, and under which revision. */
  let saved = first.draft ? undefined : first;
  let keeper: Keeper | undefined;
  function change(next: PlanDocument, what = ""): void {
    if (!writable || next === history.plan) return draw();
    history.push(next, what, performance.now());
    keeper?.changed(next);
    draw();
    askCheck();
  }

  function travel(back: boolean): void {
    if (!(back ? history.undo() : history.redo())) return;
    if (selected && !placeAt(history.plan, selected)) selected = undefined;
    keeper?.changed(history.plan);
    draw();
    askCheck();
  }

  let settle: number | undefined;
  let asked = 0;
  function askCheck(): void {
    window.clearTimeout(settle);
    settle = window.setTimeout(async () => {
      const number = ++asked;
      try {
        const answer = await postJson<PlanCheck>("/api/v1/plans/check", PATIENCE_MS, plan());
        // Where there are problems, what was laid out before is nearer to the truth than nothing.
        if (number === asked) show({ ...answer, maneuvers: answer.maneuvers.length ? answer.maneuvers : check.maneuvers });
      } catch (error) {
        if (number !== asked) return;
        setText(totals, "Length, time and energy are not known");
        rebuilt(troubles, make("p", { class: "note warn" }, error instanceof Refusal ? error.message : "The server cannot be reached: the plan is not judged."));
      }
    }, CHECK_MS);
  }

  function show(answer: PlanCheck): void {
    check = answer;
    if (!history.plan.maneuvers.length) {
      // That there is nothing yet is no problem to shout about.
      setText(totals, "Nothing is drawn yet");
      totals.removeAttribute("data-bad");
      troubles.replaceChildren();
      verdict.update(plan(), [], null);
      profile.update([]);
      return;
    }
    const { length_m, duration_s, energy_j } = answer.total;
    const round = history.plan.repeat ? "A round: " : "";
    const refused = answer.guard?.outcome === "refused";
    setText(totals, answer.problems.length ? `${answer.problems.length === 1 ? "1 problem" : `${answer.problems.length} problems`}: cannot be sailed as it is` : `${round}${lengthText(length_m)} · ${durationText(duration_s)} · ${energyText(energy_j)} (estimate)${refused ? ": refused by the chart" : ""}`);
    totals.toggleAttribute("data-bad", answer.problems.length > 0 || refused);
    const own = (one: { maneuver: string | null; text: string }): string => (one.maneuver === null ? one.text : `${one.maneuver}: ${one.text}`);
    const box = (kind: string, title: string, texts: readonly string[]): HTMLElement[] =>
      texts.length ? [make("div", { class: `note ${kind}` }, make("strong", {}, title), make("ul", {}, ...texts.slice(0, 20).map((text) => make("li", {}, text))))] : [];
    const { guard } = answer;
    const told = verdict.list(guard, (at) => {
      canvas.reveal(at);
      map.overlays.cursor(at);
    });
    rebuilt(troubles, ...box("bad", "Problems", answer.problems.map(own)), ...told, ...box("warn", "To know", answer.warnings.map(own)));
    verdict.update(plan(), answer.maneuvers, guard);
    profile.update(wayOfAll(plan(), answer.maneuvers));
    steps.check(answer);
    canvas.update(plan(), selected, answer.maneuvers);
  }

  function draw(): void {
    const now = plan();
    canvas.update(now, selected, check.maneuvers);
    steps.update(now, selected, minutes);
    if (!writable) for (const one of side.querySelectorAll<HTMLInputElement>(".plan-form input, .plan-form select, .plan-form .row button, .order-buttons button")) one.disabled = true;
    drawHead();
    setAttribute(undo, "disabled", history.canUndo && writable ? null : "");
    setAttribute(redo, "disabled", history.canRedo && writable ? null : "");
    for (const button of tools.querySelectorAll<HTMLElement>("[data-tool]")) setAttribute(button, "aria-pressed", String((button.dataset["tool"] || undefined) === tool));
    mapBox.dataset["tool"] = tool ?? "";
  }

  function drawHead(): void {
    const now = history.plan;
    const bytes = (text: string): number => new TextEncoder().encode(text).length;
    const name = textField(
      "Name of the plan",
      "plan-name",
      now.name,
      (text) => (text.trim() && bytes(text.trim()) <= 60 ? { value: text.trim() } : { wrong: "1 to 60 bytes" }),
      (value) => change({ ...now, name: value }),
    );
    const text = textField("What for", "plan-text", now.description, (value) => (value.length <= 500 ? { value } : { wrong: "up to 500 letters" }), (description) => change({ ...now, description }));
    const vessels: (readonly [string, string])[] = [["", "any vessel"], ...Object.entries(names)];
    const vessel = now.vessel === null ? "" : String(now.vessel);
    if (vessel && !(vessel in names)) vessels.push([vessel, hexAddress(Number(vessel))]);
    const forWhom = choiceField("For", "plan-vessel", vessel, vessels, (value) => change({ ...now, vessel: value ? Number(value) : null }));
    const repeat = checkField("Repeat", "plan-repeat", now.repeat, (value) => change({ ...now, repeat: value }));
    const form = choiceField("Coordinates", "minutes", minutes ? "yes" : "no", [["no", "decimal degrees"], ["yes", "degrees and minutes"]], (value) => {
      minutes = value === "yes";
      localStorage.setItem(MINUTES_KEY, value);
      draw();
    });
    const speed = defaultSpeed();
    const forAll = numberField("Speed of all", "speed-all", speed.value, 0.01, 1_000, (value) => change(withSpeed(history.plan, { value, unit: speed.unit })));
    const unit = choiceField("Unit of all", "unit-all", speed.unit, UNITS, (value) => change(withSpeed(history.plan, { value: speed.value, unit: value as SpeedUnit })));
    const save = make("button", { type: "button", class: "main", "data-key": "save" }, "Save");
    save.addEventListener("click", () => void saveNow());
    const link = (format: string, label: string): HTMLElement => make("a", { class: "button", href: `${path}/export?format=${format}`, download: "", "data-key": `export-${format}` }, label);
    const files = make("span", { class: "buttons", role: "group", "aria-label": "Download" }, link("imc", "IMC JSON"), link("geojson", "GeoJSON"), link("gpx", "GPX"));
    rebuilt(
      head,
      make("div", { class: "row" }, ...(writable ? [save] : []), make("span", { class: "download" }, "Download ", files)),
      make("div", { class: "fields" }, name, text, forWhom, form, ...(history.plan.maneuvers.length ? [forAll, unit] : []), repeat),
    );
    if (!writable) for (const one of head.querySelectorAll<HTMLInputElement>("input, select:not([data-key=minutes])")) one.disabled = true;
    chrome.stop?.target(now.vessel === null ? undefined : { address: now.vessel, name: names[vessel] ?? hexAddress(now.vessel) });
  }

  async function saveNow(): Promise<void> {
    let problems: PlanCheck["problems"] = [];
    try {
      // What was judged last may be older than what is drawn.
      problems = (await postJson<PlanCheck>("/api/v1/plans/check", PATIENCE_MS, history.plan)).problems;
    } catch {
      // Saving tells by itself why the server does not answer.
    }
    if (problems.length) {
      setText(status, "Not saved: the plan has problems. It is kept as a draft.");
      status.dataset["state"] = "failed";
      return;
    }
    await keeper?.save(history.plan);
  }

  function keeping(now: Keeping): void {
    if ("stored" in now) saved = now.stored.draft ? undefined : now.stored;
    status.dataset["state"] = now.state;
    switch (now.state) {
      case "kept":
        return setText(status, `Kept as draft ${utc(now.stored.updated_us, false)}, revision ${now.stored.revision}`);
      case "saved":
        return setText(status, `Saved ${utc(now.stored.updated_us, false)}, revision ${now.stored.revision}${now.stored.check.guard?.outcome === "refused" ? "; the chart refuses it as it is" : ""}`);
      case "changed":
      case "keeping":
        return setText(status, "Keeping …");
      case "failed": {
        const here = now.local ? "It is kept in this browser" : "THIS BROWSER COULD NOT KEEP IT EITHER: do not close the page";
        return setText(status, `Not on the server: ${now.text} ${here}${now.again ? "; trying again …" : "."}`);
      }
      case "conflict":
        setText(status, "Not on the server: somebody else changed the plan. Yours is kept in this browser.");
        return conflict(now.newer);
    }
  }

  function conflict(newer: StoredPlan): void {
    const button = (text: string, done: () => unknown): HTMLElement => {
      const made = make("button", { type: "button" }, text);
      made.addEventListener("click", () => void done());
      return made;
    };
    const mine = button("Keep mine as a plan of its own", async () => {
      try {
        const made = await postJson<StoredPlan>("/api/v1/plans", PATIENCE_MS, history.plan);
        keeper?.rebase(newer);
        location.assign(`/plans/${made.id}`);
      } catch (error) {
        setText(status, `Not kept: ${reason(error)} Yours is still in this browser.`);
      }
    });
    const theirs = button("Go on with theirs", () => {
      keeper?.rebase(newer);
      offers.replaceChildren();
      history.push(newer.plan);
      selected = undefined;
      show(newer.check);
      draw();
      keeping({ state: newer.draft ? "kept" : "saved", stored: newer });
    });
    const over = button("Put mine over theirs", () => {
      keeper?.rebase(newer);
      offers.replaceChildren();
      keeper?.changed(history.plan);
    });
    const text = `${newer.author} changed this plan at ${utc(newer.updated_us, false)} (revision ${newer.revision}, ${newer.plan.maneuvers.length} maneuvers) while you did. Nothing is lost: theirs is on the server, yours is here.`;
    offers.replaceChildren(make("div", { class: "note bad", role: "alert" }, make("p", {}, text), make("div", { class: "row" }, mine, theirs, over)));
  }

  function offer(left: Left): void {
    const take = make("button", { type: "button", class: "main" }, "Go on with it");
    const drop = make("button", { type: "button" }, "Forget it");
    take.addEventListener("click", () => {
      offers.replaceChildren();
      forget(left);
      selected = undefined;
      change(left.plan);
      canvas.fit();
    });
    drop.addEventListener("click", () => {
      forget(left);
      offers.replaceChildren();
    });
    const then = utc(left.savedMs * 1_000);
    const other = left.revision === first.revision ? "" : ` Meanwhile the plan on the server went on from revision ${left.revision} to ${first.revision}.`;
    const text = `This browser holds a state of the plan from ${then} that did not reach the server.${other}`;
    offers.replaceChildren(make("div", { class: "note warn", role: "alert" }, make("p", {}, text), make("div", { class: "row" }, take, drop)));
  }

  // The tools.
  const press = (kind: TaskKind | undefined): void => {
    tool = tool === kind ? undefined : kind;
    draw();
  };
  const toolButton = (kind: TaskKind | "", label: string): HTMLElement => {
    const made = make("button", { type: "button", "data-tool": kind, "aria-pressed": "false" }, label);
    made.addEventListener("click", () => press(kind || undefined));
    return made;
  };
  const undo = make("button", { type: "button", "aria-keyshortcuts": "Control+Z", title: "Ctrl and Z" }, "Undo");
  const redo = make("button", { type: "button", "aria-keyshortcuts": "Control+Y", title: "Ctrl and Y" }, "Redo");
  undo.addEventListener("click", () => travel(true));
  redo.addEventListener("click", () => travel(false));
  const kind = make("select", { "aria-label": "What to add" }, ...KINDS.map(([name, label]) => make("option", { value: name }, label)));
  const addHere = make("button", { type: "button", title: "After the chosen maneuver, in the middle of the map" }, "Add");
  addHere.addEventListener("click", () => {
    selected = selected && { step: selected.step, point: 0 };
    const now = history.plan;
    const at = selected ? selected.step + 1 : now.maneuvers.length;
    selected = { step: at, point: 0 };
    change(withNew(now, kind.value as TaskKind, canvas.centre(), defaultSpeed(), at));
    steps.focus();
  });
  if (writable) {
    tools.append(
      make("span", { class: "buttons", role: "group", "aria-label": "What a click on the map does" }, toolButton("", "Choose"), ...KINDS.map(([name, label]) => toolButton(name, label))),
      make("span", { class: "buttons", role: "group", "aria-label": "Back and forth" }, undo, redo),
      make("span", { class: "buttons", role: "group", "aria-label": "Add by keyboard" }, kind, addHere),
    );
  } else {
    tools.append(make("p", { class: "dim" }, "You may look at this plan, not change it."));
  }

  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
    const { target } = event;
    // A text that is being typed is taken back by the browser.
    if (target instanceof HTMLInputElement && target.type === "text" && target.value !== target.defaultValue) return;
    const key = event.key.toLowerCase();
    if (key === "s") void saveNow();
    else if (key === "y" || (key === "z" && event.shiftKey)) travel(false);
    else if (key === "z") travel(true);
    else return;
    event.preventDefault();
  });
  mapBox.addEventListener(
    "keydown",
    (event) => {
      const [north, east] = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowRight: [0, 1], ArrowLeft: [0, -1] }[event.key] ?? [0, 0];
      const place = selected && placeAt(history.plan, selected);
      if (event.key === "Escape") {
        selected = undefined;
        tool = undefined;
        draw();
      } else if (event.key === "Delete" && selected && writable) remove(selected, false);
      else if (selected && place && writable && (north || east)) {
        const by = NUDGE_M * (event.shiftKey ? 10 : 1);
        change(withPlace(history.plan, selected, displaced(place, (north ?? 0) * by, (east ?? 0) * by)), `nudge ${selected.step} ${selected.point}`);
      } else return;
      event.preventDefault();
      event.stopPropagation();
    },
    { capture: true },
  );

  let seen = vertexCount(first.plan) > 0;
  const aboard = writable
    ? createAboard(ship, {
        me: root.dataset["me"] ?? "",
        names,
        path,
        saved() {
          const digest = saved?.check.digest;
          return saved && digest && same(saved.plan, history.plan) ? { name: saved.plan.name, revision: saved.revision, digest } : undefined;
        },
        pick: (told) => map.overlays.pick(told),
        mark: (place) => map.overlays.cursor(place ? { lat_deg: place[0], lon_deg: place[1] } : null),
      })
    : undefined;
  let fleet = EMPTY;
  let linked = true;
  const drawVessels = (): void => {
    const nowUs = serverNowUs(fleet, performance.now());
    map.update(systems.map((system) => asSeen(system, fleet.values.get(system.address), nowUs, linked)), undefined, nowUs);
  };
  window.setInterval(() => chrome.draw("vessels", drawVessels), VESSELS_MS);
  const chrome = createChrome({ messages: ["VehicleState", "EstimatedState", "GpsFix", "Announce"], events: false, every_ms: 500 }, {
    lost() {
      linked = false;
      drawVessels();
    },
    frame(state, frame) {
      [fleet, linked] = [state, true];
      systems = [...state.systems.values()].map((system) => ({ ...system, name: names[String(system.address)] ?? system.name }));
      drawVessels();
      aboard?.frame(frame, systems, serverNowUs(state, performance.now()));
      // The map goes to the vessels at first; a plan that has places counts for more.
      if (seen && systems.some((system) => system.fix)) {
        seen = false;
        canvas.fit();
      }
    },
  });
  if (writable) {
    keeper = createKeeper(first, keeping);
    const [left] = leftovers(first.id);
    if (left && !same(left.plan, first.plan)) offer(left);
    else if (left) forget(left);
  }
  setText(status, `${first.draft ? "Draft" : "Saved"} by ${first.author}, ${utc(first.updated_us)}, revision ${first.revision}`);
  status.dataset["state"] = first.draft ? "kept" : "saved";
  show(first.check);
  draw();
  canvas.fit();
}

function vertexCount(plan: PlanDocument): number {
  return plan.maneuvers.reduce((sum, step) => sum + placesOf(step.task).length, 0);
}
