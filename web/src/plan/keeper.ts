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
  /** Keeps what waits as a draft now; resolves when that is done or has failed. */
  keepDraft(): Promise<void>;
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
  const keeper = new OfPlan(first, told);
  window.addEventListener("beforeunload", (event) => {
    // Only where the browser itself could not keep it would something be lost.
    if (!keeper.done && !keeper.keptHere()) event.preventDefault();
  });
  return keeper;
}

class OfPlan implements Keeper {
  private readonly id: number;
  private readonly key: string;
  private revision: number;
  private waiting: PlanDocument | undefined;
  private underWay: Promise<boolean> | undefined;
  private timer: number | undefined;
  private wait = FIRST_WAIT_MS;
  private conflict = false;
  /** What was sent from this revision without an answer: the server may have taken one of them all the same. */
  private unanswered: readonly PlanDocument[] = [];

  constructor({ id, revision }: StoredPlan, private readonly told: (keeping: Keeping) => void) {
    [this.id, this.key, this.revision] = [id, `${PREFIX}${id}.${windowKey()}`, revision];
  }

  changed(plan: PlanDocument): void {
    this.waiting = plan;
    this.keepHere(plan);
    if (this.conflict) return;
    this.told({ state: "changed" });
    this.later(SETTLE_MS);
  }

  async save(plan: PlanDocument): Promise<void> {
    while (this.underWay) await this.underWay;
    this.waiting = plan;
    this.keepHere(plan);
    await this.keep(false);
  }

  async keepDraft(): Promise<void> {
    while (this.underWay) await this.underWay;
    await this.keep(true);
  }

  rebase({ revision }: StoredPlan): void {
    this.revision = revision;
    this.conflict = false;
    this.waiting = undefined;
    localStorage.removeItem(this.key);
  }

  get done(): boolean {
    return this.waiting === undefined;
  }

  /** Whether this browser has it. */
  keptHere(): boolean {
    return localStorage.getItem(this.key) !== null;
  }

  private keepHere(plan: PlanDocument): void {
    try {
      localStorage.setItem(this.key, JSON.stringify({ revision: this.revision, savedMs: Date.now(), plan }));
    } catch {
      // Whoever leaves the page then is asked first.
    }
  }

  private later(ms: number): void {
    window.clearTimeout(this.timer);
    this.timer = window.setTimeout(() => void this.keep(true), ms);
  }

  /** Whether the server took it. One at a time, so that a revision is never used twice. */
  private async keep(draft: boolean): Promise<boolean> {
    window.clearTimeout(this.timer);
    while (this.underWay) await this.underWay;
    const plan = this.waiting;
    if (!plan || this.conflict) return false;
    this.told({ state: "keeping" });
    this.underWay = this.send(plan, draft);
    const good = await this.underWay;
    this.underWay = undefined;
    if (good && this.waiting) this.later(SETTLE_MS);
    return good;
  }

  private async send(plan: PlanDocument, draft: boolean): Promise<boolean> {
    const change: PlanChange = { revision: this.revision, draft, plan };
    try {
      this.taken(plan, draft, await putJson<StoredPlan>(`/api/v1/plans/${this.id}`, change, PATIENCE_MS));
      return true;
    } catch (error) {
      const newer = error instanceof Refusal ? (error.answer as { newer?: StoredPlan } | undefined)?.newer : undefined;
      if (newer && this.unanswered.some((one) => same(newer.plan, one))) {
        // It is our own change whose answer was lost.
        this.unanswered = [];
        this.revision = newer.revision;
        return await this.send(plan, draft);
      }
      if (newer) {
        this.conflict = true;
        this.told({ state: "conflict", newer });
      } else this.failed(plan, error);
      return false;
    }
  }

  private taken(plan: PlanDocument, draft: boolean, stored: StoredPlan): void {
    this.revision = stored.revision;
    this.wait = FIRST_WAIT_MS;
    this.unanswered = [];
    if (this.waiting === plan) {
      this.waiting = undefined;
      localStorage.removeItem(this.key);
      this.told({ state: draft ? "kept" : "saved", stored });
    } else if (this.waiting) this.keepHere(this.waiting);
  }

  /** What the server refuses it refuses again; what did not reach it is sent again. */
  private failed(plan: PlanDocument, error: unknown): void {
    if (!(error instanceof Refusal)) this.unanswered = [...this.unanswered.slice(1 - UNANSWERED), plan];
    const again = !(error instanceof Refusal) || error.status >= 500 || error.status === 429;
    this.told({ state: "failed", text: reason(error), again, local: this.keptHere() });
    if (!again) return;
    this.later(this.wait);
    this.wait = Math.min(this.wait * 2, LONGEST_WAIT_MS);
  }
}
