// Keeps what is drawn: in this browser at once, on the server as a draft a moment later, and again until it is there.

import { putJson, reason, Refusal } from "../api/http";
import type { PlanChange, PlanDocument, StoredPlan } from "../api/types.gen";
import { same } from "../state/plan";
import { windowKey } from "../state/window";

/** A change goes to the server this long after the last one, ms. */
const SETTLE_MS = 700;
const FIRST_WAIT_MS = 2_000;
const LONGEST_WAIT_MS = 10_000;
const PATIENCE_MS = 10_000;
const UNANSWERED = 30;

/** What was not brought to the server, as it lies in the browser. */
export interface Left {
  readonly key: string;
  readonly revision: number;
  readonly savedMs: number;
  readonly plan: PlanDocument;
}

export type Keeping =
  | { readonly state: "kept" | "saved"; readonly stored: StoredPlan }
  | { readonly state: "changed" | "keeping" }
  | { readonly state: "failed"; readonly text: string; readonly again: boolean; readonly local: boolean }
  | { readonly state: "conflict"; readonly newer: StoredPlan };

export interface Keeper {
  /** There is something newer than what the server has. */
  changed(plan: PlanDocument): void;
  /** Saves for good; resolves when that is done or has failed. */
  save(plan: PlanDocument): Promise<void>;
  /** Goes on from another revision: of somebody else, or after a conflict. */
  rebase(stored: StoredPlan): void;
  /** Whether all that was drawn is on the server. */
  readonly done: boolean;
}

const PREFIX = "lutra.plan.";

/** What was left of this plan by pages whose server was away, the newest first. */
export function leftovers(id: number): Left[] {
  const found: Left[] = [];
  for (let at = 0; at < localStorage.length; at++) {
    const key = localStorage.key(at);
    if (!key?.startsWith(`${PREFIX}${id}.`)) continue;
    try {
      found.push({ ...(JSON.parse(localStorage.getItem(key) ?? "") as Omit<Left, "key">), key });
    } catch {
      localStorage.removeItem(key);
    }
  }
  return found.sort((one, other) => other.savedMs - one.savedMs);
}

export function forget(left: Left): void {
  localStorage.removeItem(left.key);
}

export function createKeeper(first: StoredPlan, told: (keeping: Keeping) => void): Keeper {
  const key = `${PREFIX}${first.id}.${windowKey()}`;
  let revision = first.revision;
  let waiting: PlanDocument | undefined;
  let underWay: Promise<boolean> | undefined;
  let timer: number | undefined;
  let wait = FIRST_WAIT_MS;
  let conflict = false;
  /** What was sent from this revision without an answer: the server may have taken one of them all the same. */
  let unanswered: PlanDocument[] = [];

  const local = (plan: PlanDocument): boolean => {
    try {
      localStorage.setItem(key, JSON.stringify({ revision, savedMs: Date.now(), plan }));
      return true;
    } catch {
      return false;
    }
  };
  const later = (ms: number): void => {
    window.clearTimeout(timer);
    timer = window.setTimeout(() => void keep(true), ms);
  };
  /** Whether the server took it. One at a time, so that a revision is never used twice. */
  const keep = async (draft: boolean): Promise<boolean> => {
    window.clearTimeout(timer);
    while (underWay) await underWay;
    const plan = waiting;
    if (!plan || conflict) return false;
    told({ state: "keeping" });
    underWay = send(plan, draft);
    const good = await underWay;
    underWay = undefined;
    if (good && waiting) later(SETTLE_MS);
    return good;
  };
  const send = async (plan: PlanDocument, draft: boolean): Promise<boolean> => {
    const change: PlanChange = { revision, draft, plan };
    try {
      const stored = await putJson<StoredPlan>(`/api/v1/plans/${first.id}`, change, PATIENCE_MS);
      revision = stored.revision;
      wait = FIRST_WAIT_MS;
      unanswered = [];
      if (waiting === plan) {
        waiting = undefined;
        localStorage.removeItem(key);
        told({ state: draft ? "kept" : "saved", stored });
      } else if (waiting) local(waiting);
      return true;
    } catch (error) {
      const newer = error instanceof Refusal ? (error.answer as { newer?: StoredPlan } | undefined)?.newer : undefined;
      if (newer && unanswered.some((one) => same(newer.plan, one))) {
        // It is our own change whose answer was lost.
        unanswered = [];
        revision = newer.revision;
        return await send(plan, draft);
      }
      if (newer) {
        conflict = true;
        told({ state: "conflict", newer });
        return false;
      }
      // What the server refuses it refuses again; what did not reach it is sent again.
      if (!(error instanceof Refusal)) unanswered = [...unanswered.slice(1 - UNANSWERED), plan];
      const again = !(error instanceof Refusal) || error.status >= 500 || error.status === 429;
      told({ state: "failed", text: reason(error), again, local: localStorage.getItem(key) !== null });
      if (again) {
        later(wait);
        wait = Math.min(wait * 2, LONGEST_WAIT_MS);
      }
      return false;
    }
  };
  window.addEventListener("beforeunload", (event) => {
    // Only where the browser itself could not keep it would something be lost.
    if (waiting && localStorage.getItem(key) === null) event.preventDefault();
  });

  return {
    changed(plan) {
      waiting = plan;
      local(plan);
      if (conflict) return;
      told({ state: "changed" });
      later(SETTLE_MS);
    },
    async save(plan) {
      while (underWay) await underWay;
      waiting = plan;
      local(plan);
      await keep(false);
    },
    rebase(stored) {
      revision = stored.revision;
      conflict = false;
      waiting = undefined;
      localStorage.removeItem(key);
    },
    get done() {
      return waiting === undefined;
    },
  };
}
