// The bar of the plan page that stays in sight: which plan, for whom, the chart's verdict, and the buttons that bring it aboard.

import { useRef } from "preact/hooks";
import type { Spot, Verdict } from "../state/planverdict";
import { t } from "../words/words";

export interface PlanBarProps {
  readonly name: string;
  /** For which vessel, in words, and how it stands there; empty where nobody may bring it aboard. */
  readonly vessel: string;
  readonly aboard: string;
  readonly verdict: Verdict;
  /** Undefined for who may only look. */
  readonly acts: PlanBarActs | undefined;
  /** Why the last upload failed; empty for nothing. */
  readonly said: string;
  go(spot: Spot): void;
}

export interface PlanBarActs {
  readonly mayUpload: boolean;
  readonly mayStart: boolean;
  /** Why not, for who rests on the button; empty while it may be done. */
  readonly whyNot: string;
  save(): void;
  upload(): void;
  start(): void;
  choose(): void;
}

export function PlanBar({ name, vessel, aboard, verdict, acts, said, go }: PlanBarProps) {
  return (
    <>
      <p class="what">
        <strong class="name" title={name}>{name}</strong>
        {acts ? <button type="button" class="for" title={t("To the choice of the vessel")} onClick={acts.choose}>{vessel}</button> : <span class="for">{vessel}</span>}
      </p>
      <VerdictButton verdict={verdict} go={go} />
      {acts && <Acts acts={acts} aboard={aboard} />}
      <p class="note bad" role="alert" hidden={!said}>{said}</p>
    </>
  );
}

function VerdictButton({ verdict, go }: Pick<PlanBarProps, "verdict" | "go">) {
  const { spot, text, state } = verdict;
  // Who hears the page is told what came out, not each time that it is asked.
  const heard = useRef("");
  if (state !== "checking") heard.current = text;
  return (
    <div class="verdict" data-verdict={state}>
      <span class="hidden" role="status">{heard.current}</span>
      {spot ? <button type="button" title={t("Show it on the map")} onClick={() => go(spot)}>{text}</button> : <span aria-hidden="true">{text}</span>}
    </div>
  );
}

function Acts({ acts, aboard }: { readonly acts: PlanBarActs; readonly aboard: string }) {
  return (
    <div class="acts">
      <span class="aboard-now">{aboard}</span>
      <button type="button" onClick={acts.save}>{t("Save")}</button>
      <button type="button" class="main" disabled={!acts.mayUpload} title={acts.whyNot} onClick={acts.upload}>{t("Upload")}</button>
      <button type="button" class="main" disabled={!acts.mayStart} title={acts.whyNot} onClick={acts.start}>{t("Start …")}</button>
    </div>
  );
}
