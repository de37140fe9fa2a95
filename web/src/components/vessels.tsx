// The vessels beside the map: those with a name from people, and below one heading all others that are heard.

import type { Card } from "../state/card";
import { type Order, ORDERS } from "../state/order";
import { t, tn } from "../words/words";
import { VesselCard } from "./card";
import { FirstSteps } from "./firststeps";

export interface VesselsProps {
  readonly ours: readonly Card[];
  readonly strangers: readonly Card[];
  readonly selected: number | undefined;
  readonly order: Order;
  /** Whether those without a name are unfolded. */
  readonly open: boolean;
  select(address: number): void;
  sort(order: Order): void;
  unfold(open: boolean): void;
}

export function Vessels(props: VesselsProps) {
  const { ours, strangers } = props;
  return (
    <>
      {ours.length + strangers.length > 1 && <Sort order={props.order} sort={props.sort} />}
      {ours.length + strangers.length === 0 && <FirstSteps />}
      {ours.length > 0 && <Cards {...props} cards={ours} label={t("Vessels")} />}
      {strangers.length > 0 && (
        <div class="strangers">
          <h2>
            <button type="button" class="fold" aria-expanded={props.open} aria-controls="strangers" onClick={() => props.unfold(!props.open)}>{heading(strangers)}</button>
          </h2>
          <div id="strangers" hidden={!props.open}>
            <Cards {...props} cards={strangers} label={t("Systems without a name")} />
          </div>
        </div>
      )}
    </>
  );
}

function heading(strangers: readonly Card[]): string {
  const loud = strangers.filter(({ worst }) => !worst.quiet).length;
  if (loud) return tn(strangers.length, "{n} system not registered here, {loud} with trouble", "{n} systems not registered here, {loud} with trouble", { loud });
  return tn(strangers.length, "{n} system not registered here", "{n} systems not registered here");
}

function Cards({ cards, label, selected, select }: VesselsProps & { readonly cards: readonly Card[]; readonly label: string }) {
  return (
    <ul class="systems" aria-label={label}>
      {cards.map((card) => <VesselCard key={card.address} card={card} selected={card.address === selected} select={select} />)}
    </ul>
  );
}

function Sort({ order, sort }: { readonly order: Order; sort(order: Order): void }) {
  return (
    <div class="list-head">
      <label>
        {t("Sort by")}{" "}
        <select value={order} onChange={(event) => sort(event.currentTarget.value as Order)}>
          {ORDERS.map(([value, text]) => <option key={value} value={value}>{text}</option>)}
        </select>
      </label>
    </div>
  );
}
