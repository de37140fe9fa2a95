// The links of a vessel that has several: which carries what, and how good each is.

import type { WayRow } from "../state/ways";
import { t } from "../words/words";

export function LinkTable({ rows }: { readonly rows: readonly WayRow[] }) {
  if (!rows.length) return null;
  return (
    <section class="links" aria-label={t("Links of this vessel")}>
      <h3>{t("Links of this vessel")}</h3>
      <div class="wide" tabIndex={0} role="region" aria-label={t("Links of this vessel")}>
        <table class="compact">
          <thead><tr>{[t("Link"), t("State"), t("Carries"), t("Round trip"), t("Late messages"), t("Fastest rate"), t("Used today (UTC)")].map((head) => <th key={head} scope="col">{head}</th>)}</tr></thead>
          <tbody>
            {rows.map(({ name, state, good, carries, trip, late, rate, today }) => (
              <tr key={name}>
                <th scope="row">{name}</th>
                <td data-state={good ? "NORMAL" : "ERROR"}><span aria-hidden="true">{good ? "●" : "▲"}</span> {state}</td>
                <td>{carries}</td>
                <td class="num">{trip}</td>
                <td class="num">{late}</td>
                <td class="num">{rate}</td>
                <td class="num">{today}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}
