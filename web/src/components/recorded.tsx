// What was recorded, by day and vessel: to be watched, to be taken away, or chosen for a file.

import { useState } from "preact/hooks";
import type { RecordedDay } from "../api/types.gen";
import { bytesText } from "../state/takeout";
import { asCards } from "../ui/cards";
import { utc } from "../ui/format";
import { count, t } from "../words/words";

/** Rows that are shown at first, and more with each asking. */
const PAGE = 40;

interface Needs {
  readonly days: readonly RecordedDay[];
  called(day: RecordedDay): string;
  /** Whether the person may take data away. */
  readonly may: boolean;
  choose(day: RecordedDay): void;
}

export function Recorded({ days, called, may, choose }: Needs) {
  const [shown, more] = useState(PAGE);
  return (
    <>
      <div class="wide" tabIndex={0} role="region" aria-label={t("Recorded days")}>
        <table class="compact" ref={(table) => void (table && asCards(table))}>
          <thead><tr>{[t("Received (UTC)"), t("Vessel"), t("From (UTC)"), t("To (UTC)"), t("Packets"), t("Size"), ""].map((head) => <th key={head} scope="col">{head || <span class="hidden">{t("Actions")}</span>}</th>)}</tr></thead>
          <tbody>
            {days.slice(0, shown).map((day) => (
              <tr key={`${day.day_us}/${day.system}`}>
                <td class="num" data-name={t("Received (UTC)")}>{utc(day.day_us).slice(0, 10)}</td>
                <th scope="row">{called(day)}</th>
                <td class="num" data-name={t("From (UTC)")}>{utc(day.first_us)}</td>
                <td class="num" data-name={t("To (UTC)")}>{utc(day.last_us)}</td>
                <td class="num right" data-name={t("Packets")}>{count(day.packets)}</td>
                <td class="num right" data-name={t("Size")}>{bytesText(day.bytes)}</td>
                <td>
                  <span class="row">
                    <a class="button" href={watch(day)}>{t("Watch")}</a>
                    {may && day.bytes > 0 && <a class="button" download href={`/api/v1/export.lsf?vessel=${day.system}&from=${iso(day.first_us)}&to=${iso(day.last_us + 1)}`}>{t("Log")}</a>}
                    {may && <button type="button" onClick={() => choose(day)}>{t("Choose")}</button>}
                  </span>
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      {days.length > shown && <button type="button" onClick={() => more(shown + PAGE)}>{t("Older days ({n} more)", { n: days.length - shown })}</button>}
    </>
  );
}

/** The vessel's page over the time of the day's packets. */
function watch({ system, first_us, last_us }: RecordedDay): string {
  return `/vessels/${system}?tab=Plots&from=${first_us}&to=${Math.max(last_us, first_us + 1_000_000)}`;
}

function iso(us: number): string {
  return new Date(us / 1_000).toISOString();
}
