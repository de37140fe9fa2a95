// Several of a list, by check boxes behind a line that says what is chosen; none chosen is all.

import { useRef } from "preact/hooks";
import { t } from "../words/words";

interface Needs {
  readonly label: string;
  /** What is chosen where nothing is. */
  readonly all: string;
  readonly options: readonly (readonly [value: string, text: string])[];
  readonly chosen: readonly string[];
  choose(chosen: readonly string[]): void;
}

/** More names than this are only counted. */
const NAMED = 2;

export function Choices({ label, all, options, chosen, choose }: Needs) {
  const called = new Map(options);
  // What the page's address asks for is there to be taken out, though nobody knows it.
  const shown = [...options, ...chosen.filter((value) => !called.has(value)).map((value) => [value, value] as const)];
  const names = chosen.map((value) => called.get(value) ?? value);
  const said = !names.length ? all : names.length <= NAMED ? names.join(", ") : t("{n} chosen", { n: names.length });
  const set = (value: string, on: boolean): void => choose(on ? [...chosen, value] : chosen.filter((one) => one !== value));
  const box = useRef<HTMLDetailsElement>(null);
  // Whoever goes on to the next field is done with this one.
  const left = ({ relatedTarget }: FocusEvent): void => {
    if (box.current && relatedTarget instanceof Node && !box.current.contains(relatedTarget)) box.current.open = false;
  };
  return (
    <div class="field choices">
      <span aria-hidden="true">{label}</span>
      <details ref={box} onFocusOut={left}>
        <summary aria-label={`${label}: ${said}`}>{said}</summary>
        <div role="group" aria-label={label}>
          {shown.map(([value, text]) => <label key={value} class="inline"><input type="checkbox" checked={chosen.includes(value)} onChange={(event) => set(value, event.currentTarget.checked)} /> {text}</label>)}
          {!shown.length && <p class="dim">{t("none")}</p>}
        </div>
      </details>
    </div>
  );
}
