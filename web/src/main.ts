// Starts what the page is about. What only some pages need is loaded by those.

import { createChrome } from "./ui/chrome";
import { offerCopies } from "./ui/copy";
import { tellLanguage } from "./ui/language";

const [fleet, vessel, plan] = [document.getElementById("fleet"), document.getElementById("vessel"), document.getElementById("plan")];
const [detections, data] = [document.getElementById("detections"), document.getElementById("data")];
const [style, noGo] = [document.getElementById("style"), document.getElementById("no-go-areas")];
const [datasets, dataset] = [document.getElementById("datasets"), document.getElementById("dataset")];
const [register, explore] = [document.getElementById("register"), document.getElementById("explore")];
const [logbook, missions, mission] = [document.getElementById("logbook"), document.getElementById("missions"), document.getElementById("mission")];
if (fleet) {
  void import("./pages/fleet").then(({ startFleet }) => startFleet(fleet));
} else if (vessel) {
  void import("./pages/vessel").then(({ startVessel }) => startVessel(vessel));
} else if (plan) {
  void import("./pages/plan").then(({ startPlan }) => startPlan(plan));
} else if (detections) {
  void import("./pages/detections").then(({ startDetections }) => startDetections(detections));
} else if (data) {
  void import("./pages/data").then(({ startData }) => startData(data));
} else if (logbook) {
  void import("./pages/logbook").then(({ startLogbook }) => startLogbook(logbook));
} else if (missions) {
  void import("./pages/missions").then(({ startMissions }) => startMissions(missions));
} else if (mission) {
  void import("./pages/mission").then(({ startMission }) => startMission(mission));
} else if (noGo) {
  void import("./pages/nogo").then(({ startNoGo }) => startNoGo(noGo));
} else if (register) {
  void import("./pages/register").then(({ startRegister }) => startRegister(register));
} else if (explore) {
  void import("./pages/explore").then(({ startExplore }) => startExplore(explore));
} else if (datasets) {
  void import("./pages/datasets").then(({ startDatasets }) => startDatasets(datasets));
} else if (dataset) {
  void import("./pages/dataset").then(({ startDataset }) => startDataset(dataset));
} else if (style) {
  void import("./pages/style").then(({ startStyle }) => startStyle(style));
} else {
  createChrome({ messages: ["VehicleState"], events: false, every_ms: 500 }, {});
  offerCopies(document);
  const form = document.querySelector<HTMLFormElement>("form#import");
  if (form) void import("./pages/import").then(({ startImport }) => startImport(form));
  const plans = document.getElementById("plans");
  if (plans) void import("./pages/plans").then(({ startPlans }) => startPlans(plans));
}

tellLanguage();

// Only where the way to the server is encrypted, or within this computer, does a browser have it.
navigator.serviceWorker?.register("/worker.js").catch(() => undefined);
