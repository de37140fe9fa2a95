// A vessel's card: who it is, what it does, how it is, and how old all of that is.

import { type Card, NOT_REPORTED, type CardText } from "../state/card";
import { t } from "../words/words";

export interface CardProps {
  readonly card: Card;
  readonly selected: boolean;
  select(address: number): void;
}

export function VesselCard({ card, selected, select }: CardProps) {
  return (
    <li class="vessel-card" data-series={card.series}>
      <button type="button" class="system" aria-pressed={selected} data-liveness={card.liveness} onClick={() => select(card.address)}>
        <span class="name">{card.title}</span>
        <span class="state">{card.link}</span>
        <span class="doing">
          <Text class="mode" told={card.doing} />{" "}
          <Text class="plan" told={card.plan} />{" "}
          <Text class="progress num" told={card.progress} />
        </span>
        <span class="facts">
          <Fact label={t("Speed")} told={card.speed} />
          <Fact label={t("Heading")} told={card.heading} />
          <Fact label={t("Battery")} told={card.battery} warn={card.battery.low} />
          <Fact label={t("Position age")} told={card.placeAge} />
        </span>
        <Text class="place num" told={card.place} />
        <span class="worst" data-quiet={card.worst.quiet ? "" : undefined}>{card.worst.text}</span>
        <span class="heard num">{card.heard}</span>
      </button>
      <a class="more" href={`/vessels/${card.address}`} aria-label={t("Open {name}", { name: card.name })}>{t("Open")}</a>
    </li>
  );
}

function Text({ told, class: kind }: { readonly told: CardText; readonly class: string }) {
  return <span class={kind} data-old={told.old ? "" : undefined}>{told.text}</span>;
}

function Fact({ label, told, warn = false }: { readonly label: string; readonly told: CardText; readonly warn?: boolean }) {
  return (
    <span class="fact">
      <span class="what">{label} </span>
      <span class="num" data-old={told.old ? "" : undefined} data-warn={warn ? "" : undefined} data-none={told.text === NOT_REPORTED ? "" : undefined}>{told.text}</span>
    </span>
  );
}
