// Missions in a table: each leads to its page with replay, files, notes and summary.

import type { Mission } from "../api/types.gen";
import { asCards } from "../ui/cards";
import { utc } from "../ui/format";
import { t } from "../words/words";

export function MissionTable({ missions, called }: { readonly missions: readonly Mission[]; called(address: number): string }) {
  return (
    <div class="wide" tabIndex={0} role="region" aria-label={t("Missions")}>
      <table class="compact" ref={(table) => void (table && asCards(table))}>
        <thead><tr>{[t("Mission"), t("From (UTC)"), t("To (UTC)"), t("Vessels"), t("People"), t("Purpose")].map((head) => <th key={head} scope="col">{head}</th>)}</tr></thead>
        <tbody>
          {missions.map(({ id, mission, withdrawn }) => (
            <tr key={id}>
              <th scope="row"><a href={`/missions/${id}`}>{mission.name}</a>{withdrawn && ` ${t("(withdrawn)")}`}</th>
              <td class="num" data-name={t("From (UTC)")}>{utc(mission.from_us)}</td>
              <td class="num" data-name={t("To (UTC)")}>{mission.to_us === null ? t("goes on") : utc(mission.to_us)}</td>
              <td data-name={t("Vessels")}>{mission.vessels.map(called).join(", ")}</td>
              <td data-name={t("People")}>{mission.people}</td>
              <td data-name={t("Purpose")}>{mission.purpose}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
