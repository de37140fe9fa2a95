// The links of a vessel that has several: which carries what, and how good each is.

import type { WayRow } from "../state/ways";
import { t } from "../words/words";

export function LinkTable({ rows }: { readonly rows: readonly WayRow[] }) {
  if (!rows.length) return null;
  const [name, ...columns] = [t("Link"), t("State"), t("Carries"), t("Round trip"), t("Late messages"), t("Fastest rate lately"), t("Used today (UTC)")];
  return (
    <section class="links">
      <h3>{t("Links of this vessel")}</h3>
      <div class="wide" tabIndex={0} role="region" aria-label={t("Links of this vessel")}>
        <table class="compact cards" role="table">
          <thead role="rowgroup"><tr role="row">{[name, ...columns].map((head) => <th key={head} scope="col" role="columnheader">{head}</th>)}</tr></thead>
          <tbody role="rowgroup">
            {rows.map((row) => (
              <tr key={row.name} role="row">
                <th scope="row" role="rowheader">{row.name}</th>
                <td role="cell" data-name={columns[0]} data-state={row.good ? "NORMAL" : "ERROR"}><span><span aria-hidden="true">{row.good ? "●" : "▲"}</span> {row.state}</span></td>
                {[row.carries, row.trip, row.late, row.rate, row.today].map((text, at) => <td key={columns[at + 1]} role="cell" data-name={columns[at + 1]}>{text}</td>)}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}
