// From and to, typed or picked, in UTC, with spans that are often wanted.

import type { Signal } from "@preact/signals";
import { picked, timeWrong } from "../state/takeout";
import { t } from "../words/words";
import { WhenField } from "./when";

const SPANS: readonly (readonly [string, number | null])[] = [[t("Last hour"), 3_600_000], [t("Today"), 0], [t("Last 7 days"), 7 * 86_400_000], [t("All"), null]];

interface Needs {
  readonly from: Signal<string>;
  readonly to: Signal<string>;
  /** What is wrong with one of them; empty for nothing. */
  readonly fromWrong?: string;
  readonly toWrong: string;
}

export function TimeSpan({ from, to, fromWrong = "", toWrong }: Needs) {
  const [badFrom, badTo] = [timeWrong(from.value), timeWrong(to.value)];
  return (
    <>
      <Pick label={t("From (UTC)")} id="span-from" value={from} wrong={badFrom || fromWrong} />
      <Pick label={t("To (UTC)")} id="span-to" value={to} wrong={badTo || (badFrom ? "" : toWrong)} />
    </>
  );
}

function Pick({ label, id, value, wrong }: { readonly label: string; readonly id: string; readonly value: Signal<string>; readonly wrong: string }) {
  return (
    <div class="field">
      <label for={id}>{label}</label>
      <WhenField marks={{ id, "aria-invalid": wrong !== "", "aria-describedby": `${id}-wrong` }} value={value.value} changed={(text) => (value.value = text)} />
      <p id={`${id}-wrong`} class="wrong" role="alert">{wrong}</p>
    </div>
  );
}

/** Buttons that set the span; `then` is called after each. */
export function Spans({ from, to, then = () => undefined }: Pick<Needs, "from" | "to"> & { readonly then?: () => void }) {
  const set = (ms: number | null): void => {
    const begin = ms === 0 ? `${new Date().toISOString().slice(0, 10)} 00:00:00` : picked((Date.now() - (ms ?? 0)) * 1_000);
    [from.value, to.value] = [ms === null ? "" : begin, ""];
    then();
  };
  return (
    <div class="spans" role="group" aria-label={t("Often wanted")}>
      {SPANS.map(([text, ms]) => <button key={text} type="button" onClick={() => set(ms)}>{text}</button>)}
    </div>
  );
}
