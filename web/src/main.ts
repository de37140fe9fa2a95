// Starts what the page is about. What only some pages need is loaded by those.

import { createChrome } from "./ui/chrome";

const [fleet, vessel] = [document.getElementById("fleet"), document.getElementById("vessel")];
if (fleet) {
  void import("./pages/fleet").then(({ startFleet }) => startFleet(fleet));
} else if (vessel) {
  void import("./pages/vessel").then(({ startVessel }) => startVessel(vessel));
} else {
  createChrome({ messages: ["VehicleState"], events: false, every_ms: 500 }, {});
  const form = document.querySelector<HTMLFormElement>("form#import");
  if (form) void import("./pages/import").then(({ startImport }) => startImport(form));
}
