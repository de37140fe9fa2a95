// Telling the server what to do with a vessel, and waiting for what a vessel answers to a question.

import { getJson, postJson } from "../api/http";
import type { Command, Lease, LeaseAction, LeaseRequest, Order, OrderRequest } from "../api/types.gen";
import { stageInFull } from "../state/orderwords";
import { t } from "../words/words";

const PATIENCE_MS = 8_000;
/** How often a question that is open is looked at, ms. */
const LOOK_MS = 300;

export { windowKey } from "../state/window";

export interface Orders {
  lease(action: LeaseAction, reason?: string): Promise<Lease>;
  give(order: Order): Promise<Command>;
  /** The order with all that became of it, when nothing more is expected. */
  settle(order: Order): Promise<Command>;
  /** An order that was given, with all that became of it. */
  settled(command: Command): Promise<Command>;
  /** The answer to a question, or an error in the words of who refused. */
  ask(order: Order): Promise<Command>;
}

export function createOrders(vessel: number, window: string): Orders {
  const path = `/api/v1/vessels/${vessel}`;
  const give = (order: Order): Promise<Command> => postJson<Command>(`${path}/commands`, PATIENCE_MS, { order, window } satisfies OrderRequest);
  const settled = async (given: Command): Promise<Command> => {
    let command = given;
    while (!command.over) {
      await new Promise((done) => setTimeout(done, LOOK_MS));
      command = await getJson<Command>(`${path}/commands/${command.id}`);
    }
    return command;
  };
  const settle = async (order: Order): Promise<Command> => settled(await give(order));
  return {
    give,
    settle,
    settled,
    lease: (action, reason = "") => postJson<Lease>(`${path}/lease`, PATIENCE_MS, { action, reason, window } satisfies LeaseRequest),
    async ask(order) {
      const command = await settle(order);
      const last = command.steps.at(-1);
      if (last?.stage !== "effect seen") throw new Unanswered(last ? stageInFull(last) : t("not sent"));
      return command;
    },
  };
}

/** What a vessel did not answer, with the reason. */
export class Unanswered extends Error {}
