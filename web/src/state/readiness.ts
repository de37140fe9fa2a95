// Whether a vessel is ready to sail, and what stands against it: what its parts say, its chart and its link, worst first.

import type { LinkStatus } from "../api/types.gen";
import { t, tn } from "../words/words";
import { chartDiffers } from "./alarmwords";
import { type EntityReading, STATE_WORDS } from "./vitals";

export type Grade = "bad" | "attention" | "starting";

/** Something that stands against sailing: which part, and what it says, which is what to do where it knows. */
export interface Remark {
  readonly part: string;
  readonly grade: Grade;
  readonly says: string;
}

export interface Readiness {
  readonly grade: Grade | "good" | "unknown";
  readonly verdict: string;
  readonly remarks: readonly Remark[];
}

/** Records of this age wait because the link is slow or down (s). */
const OLD_BACKLOG_S = 60;
const GRADES: Readonly<Record<string, Grade>> = { BOOT: "starting", FAULT: "attention", ERROR: "bad", FAILURE: "bad" };
const ORDER: readonly Grade[] = ["bad", "attention", "starting"];

/** By the parts of a vessel as they are now, and its link where it has one with this server. */
export function readiness(parts: readonly EntityReading[], link: LinkStatus | undefined): Readiness {
  const spoke = parts.filter(({ state }) => state);
  if (!spoke.length || spoke.every(({ old }) => old)) return { grade: "unknown", verdict: t("Not known: the vessel's parts do not report"), remarks: [] };
  const remarks = [...spoke.flatMap(ofPart), ...(link ? ofLink(link) : [])].sort((one, other) => ORDER.indexOf(one.grade) - ORDER.indexOf(other.grade));
  const grade = remarks[0]?.grade ?? "good";
  return { grade, verdict: verdict(grade, remarks.length), remarks };
}

function verdict(grade: Grade | "good", remarks: number): string {
  if (grade === "good") return t("Ready to sail");
  if (grade === "starting") return t("Not ready yet");
  if (grade === "bad") return t("Not ready to sail");
  return tn(remarks, "Ready to sail, with one remark", "Ready to sail, with {n} remarks");
}

function ofPart({ entity, label, state, description, old }: EntityReading): Remark[] {
  const part = label || t("entity {entity}", { entity });
  if (old) return [{ part, grade: "attention", says: t("does not report any more") }];
  const grade = GRADES[state];
  return grade ? [{ part, grade, says: description || (STATE_WORDS[state] ?? state) }] : [];
}

function ofLink({ up, backlog_records, backlog_age_s, chart }: LinkStatus): Remark[] {
  const remarks: Remark[] = [];
  if (!up) remarks.push({ part: t("Link"), grade: "attention", says: t("is down: what happens aboard comes ashore when it is up again") });
  else if (backlog_age_s > OLD_BACKLOG_S) remarks.push({ part: t("Link"), grade: "attention", says: tn(backlog_records, "one record waits aboard", "{n} records wait aboard") });
  const { difference, digest } = chart;
  // A vessel that takes no chart from ashore is set up so; without any chart, here or there, there is nothing to compare.
  if (difference && difference.stage !== "declined" && (digest || difference.stage !== "none_ashore")) {
    remarks.push({ part: t("Sea chart"), grade: difference.stage === "failed" ? "bad" : "attention", says: chartDiffers(digest !== null, difference) });
  }
  return remarks;
}
