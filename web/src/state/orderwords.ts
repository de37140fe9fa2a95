// Orders and what becomes of them, as people say it: pure.

const ORDERS: Readonly<Record<string, string>> = {
  "vessel.abort": "STOP",
  "plan.start": "Start plan",
  "plan.stop": "Stop plan",
  "goto": "Go to",
  "teleop.begin": "Steer by hand",
  "teleop.end": "End steering by hand",
  "plan.upload": "Upload plan",
  "plan.delete": "Delete plan aboard",
  "plan.list": "List plans aboard",
  "plan.get": "Fetch plan",
  "parameters.query": "Read parameters",
  "parameters.set": "Set parameters",
  "parameters.save": "Save parameters",
};

const STAGES: Readonly<Record<string, string>> = { "effect seen": "done", "received": "received by the vessel", "timed out": "timed out without an effect" };

/** An order by its code. */
export function orderText(code: string): string {
  return ORDERS[code] ?? code;
}

/** A stage by its code. */
export function stageText(code: string): string {
  return STAGES[code] ?? code;
}
