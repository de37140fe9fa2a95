// Fields of the plan editor: they tell a change when it is whole, and say in words what they do not take.

import type { PlanPlace } from "../api/types.gen";
import { minutesRead, minutesShown, readAngle, readNumber, writeAngle } from "../state/units";
import { make, setAttribute, setText } from "../ui/dom";
import { t } from "../words/words";

interface Read<T> {
  readonly value?: T;
  readonly wrong?: string;
}

/** A labelled text field; `key` finds it again after the form was built again. */
export function textField<T>(label: string, key: string, shown: string, read: (text: string) => Read<T>, told: (value: T) => void, more: Readonly<Record<string, string>> = {}): HTMLElement {
  const wrong = make("span", { class: "bad-text wrong", id: `wrong-${key}`, role: "status" });
  const input = make("input", { type: "text", "data-key": key, value: shown, autocomplete: "off", spellcheck: "false", "aria-describedby": `wrong-${key}`, ...more });
  input.addEventListener("change", () => {
    const { value, wrong: text } = read(input.value);
    setAttribute(input, "aria-invalid", text === undefined ? null : "true");
    setText(wrong, text ?? "");
    if (value !== undefined && input.value !== shown) told(value);
  });
  return make("div", { class: "field" }, make("label", {}, label, input), wrong);
}

export function numberField(label: string, key: string, value: number, least: number, most: number, told: (value: number) => void, whole = false): HTMLElement {
  const read = (text: string): Read<number> => {
    const number = readNumber(text);
    const good = number >= least && number <= most && (!whole || Number.isInteger(number));
    return good ? { value: number } : { wrong: whole ? t("a whole number from {least} to {most}", { least, most }) : t("a number from {least} to {most}", { least, most }) };
  };
  return textField(label, key, String(value), read, told, { inputmode: "decimal", class: "num" });
}

/** A duration of whole seconds, read and typed in minutes. */
export function minutesField(label: string, key: string, seconds: number, mostS: number, told: (seconds: number) => void): HTMLElement {
  const read = (text: string): Read<number> => {
    const value = minutesRead(text);
    return value >= 0 && value <= mostS ? { value } : { wrong: t("minutes from 0 to {most}, such as 1.5 or 1:30", { most: Math.floor(mostS / 60) }) };
  };
  return textField(label, key, minutesShown(seconds), read, told, { inputmode: "decimal", class: "num" });
}

export function checkField(label: string, key: string, value: boolean, told: (value: boolean) => void): HTMLElement {
  const input = make("input", { type: "checkbox", "data-key": key });
  input.checked = value;
  input.addEventListener("change", () => told(input.checked));
  return make("label", { class: "inline" }, input, label);
}

export function choiceField(label: string, key: string, value: string, choices: readonly (readonly [string, string])[], told: (value: string) => void): HTMLElement {
  const select = make("select", { "data-key": key }, ...choices.map(([name, text]) => make("option", { value: name }, text)));
  select.value = value;
  select.addEventListener("change", () => told(select.value));
  return make("label", {}, label, select);
}

/** Latitude and longitude, typed as decimal degrees or as degrees and minutes. */
export function placeFields(key: string, what: string, place: PlanPlace, minutes: boolean, told: (place: PlanPlace) => void): HTMLElement[] {
  const field = (axis: "lat" | "lon", name: string, deg: number, change: (deg: number) => PlanPlace): HTMLElement => {
    const example = axis === "lat" ? t("63.44 or 63° 26.4′ N") : t("10.4 or 10° 24′ E");
    const read = (text: string): Read<number> => {
      const value = readAngle(text, axis);
      return value === undefined ? { wrong: t("like {example}", { example }) } : { value };
    };
    return textField(`${what}${name}`, `${key}-${axis}`, writeAngle(deg, axis, minutes), read, (value) => told(change(value)), { class: "num" });
  };
  return [
    field("lat", t("Latitude"), place.lat_deg, (lat_deg) => ({ ...place, lat_deg })),
    field("lon", t("Longitude"), place.lon_deg, (lon_deg) => ({ ...place, lon_deg })),
  ];
}

/** Builds `root` again; the focus stays in its field or on its button. */
export function rebuilt(root: HTMLElement, ...children: readonly Node[]): void {
  const active = document.activeElement;
  const key = active instanceof HTMLElement && root.contains(active) ? active.dataset["key"] : undefined;
  root.replaceChildren(...children);
  if (key !== undefined) [...root.querySelectorAll<HTMLElement>("[data-key]")].find((one) => one.dataset["key"] === key)?.focus();
}
