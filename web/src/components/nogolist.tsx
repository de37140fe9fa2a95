// No-go areas as a list: what each is, who closed it and when, and what can be done with it.

import type { NoGoArea } from "../api/types.gen";
import { utc } from "../ui/format";
import { t } from "../words/words";

export interface NoGoActions {
  show(area: NoGoArea): void;
  edit(area: NoGoArea): void;
  /** Lifts it, or closes it again. */
  close(area: NoGoArea, closed: boolean): void;
}

interface Needs {
  readonly areas: readonly NoGoArea[];
  readonly mayChange: boolean;
  readonly busy: boolean;
  readonly act: NoGoActions;
}

export function NoGoList({ areas, mayChange, busy, act }: Needs) {
  const closed = areas.filter(({ lifted }) => lifted === null);
  const lifted = areas.filter((area) => area.lifted !== null);
  return (
    <>
      {closed.length === 0 && <p>{mayChange ? t("No areas are closed. Close waters that vessels must keep out of and that no chart shows: fish farms, nets, moorings, rocks.") : t("No areas are closed. Operators of all vessels close them.")}</p>}
      <ul class="nogo-list" aria-label={t("Closed areas")}>{closed.map((area) => <Entry key={area.id} area={area} mayChange={mayChange} busy={busy} act={act} />)}</ul>
      {lifted.length > 0 && (
        <details>
          <summary>{t("Lifted areas ({n})", { n: lifted.length })}</summary>
          <ul class="nogo-list" aria-label={t("Lifted areas")}>{lifted.map((area) => <Entry key={area.id} area={area} mayChange={mayChange} busy={busy} act={act} />)}</ul>
        </details>
      )}
    </>
  );
}

function Entry({ area, mayChange, busy, act }: Omit<Needs, "areas"> & { readonly area: NoGoArea }) {
  const { name, reason } = area.area;
  const isClosed = area.lifted === null;
  const { by, time_us } = area.lifted ?? area.changed ?? area.written;
  const told = isClosed ? (area.changed ? t("Changed by {by}, {time}", { by, time: utc(time_us) }) : t("Closed by {by}, {time}", { by, time: utc(time_us) })) : t("Lifted by {by}, {time}", { by, time: utc(time_us) });
  return (
    <li>
      <h3>{name}</h3>
      {reason && <p class="said">{reason}</p>}
      <p class="dim num">{told}</p>
      <p class="row">
        <button type="button" aria-label={t("Show {name} on the map", { name })} onClick={() => act.show(area)}>{t("Show")}</button>
        {mayChange && isClosed && <button type="button" aria-label={t("Change {name}", { name })} disabled={busy} onClick={() => act.edit(area)}>{t("Change")}</button>}
        {mayChange && isClosed && <button type="button" aria-label={t("Lift {name}", { name })} disabled={busy} onClick={() => act.close(area, false)}>{t("Lift")}</button>}
        {mayChange && !isClosed && <button type="button" aria-label={t("Close {name} again", { name })} disabled={busy} onClick={() => act.close(area, true)}>{t("Close again")}</button>}
      </p>
    </li>
  );
}
