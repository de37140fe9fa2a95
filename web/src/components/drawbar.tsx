// What belongs to an area while it is drawn: spacing, bearing, what becomes of it, and its end.

import { useId, useState } from "preact/hooks";
import { t } from "../words/words";

export interface DrawBarProps {
  /** What to do next, or what would become of it. */
  readonly told: string;
  readonly spacing_m: number;
  readonly bearing_deg: number | undefined;
  /** What the bearing is when none is given. */
  readonly suits: string;
  /** It can be taken as it is. */
  readonly whole: boolean;
  /** Whether it is finished by a button; a rectangle is by its second corner. */
  readonly finishes: boolean;
  spacing(metres: number): void;
  bearing(deg: number | undefined): void;
  finish(): void;
  cancel(): void;
}

export function DrawBar(props: DrawBarProps) {
  const { told, spacing_m, bearing_deg, suits, whole, finishes } = props;
  return (
    <>
      <NumberField label={t("Spacing, m")} value={String(spacing_m)} least={0.5} most={5_000} told={(value) => value !== undefined && props.spacing(value)} />
      <NumberField label={t("Bearing, ° true")} value={bearing_deg === undefined ? "" : String(bearing_deg)} least={-360} most={360} hint={suits} told={props.bearing} />
      {finishes && <button type="button" class="main" disabled={!whole} onClick={props.finish}>{t("Finish")}</button>}
      <button type="button" title={t("Escape on the map does the same")} onClick={props.cancel}>{t("Cancel")}</button>
      <p class="told" role="status">{told}</p>
    </>
  );
}

interface NumberProps {
  readonly label: string;
  readonly value: string;
  readonly least: number;
  readonly most: number;
  readonly hint?: string;
  /** Undefined for an empty field. */
  told(value: number | undefined): void;
}

function NumberField({ label, value, least, most, hint = "", told }: NumberProps) {
  const id = useId();
  const [wrong, setWrong] = useState("");
  const change = (input: HTMLInputElement): void => {
    const text = input.value.trim().replace(",", ".").replace("−", "-");
    const number = Number(text);
    const good = text === "" || (number >= least && number <= most);
    setWrong(good ? "" : t("a number from {least} to {most}", { least, most }));
    if (good) told(text === "" ? undefined : number);
  };
  return (
    <label for={id}>
      {label}
      <input id={id} class="num" aria-invalid={wrong !== ""} aria-describedby={`${id}-wrong`} type="text" inputMode="decimal" autocomplete="off" value={value} placeholder={hint} onChange={(event) => change(event.currentTarget)} />
      <span id={`${id}-wrong`} class="bad-text wrong" role="status">{wrong}</span>
    </label>
  );
}
