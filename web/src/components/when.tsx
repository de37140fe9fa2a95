// A field of a time or a day: typed, or chosen in the browser's calendar.

import { useEffect, useRef, useState } from "preact/hooks";
import { isTime } from "../state/takeout";
import { LIKE, type When, withCalendar } from "../ui/when";

interface Needs {
  readonly marks: { readonly id: string; readonly "aria-invalid": boolean; readonly "aria-describedby": string };
  readonly value: string;
  readonly kind?: When;
  /** Told of each whole time at once, and of what is none when the field is left. */
  told(text: string): void;
}

export function WhenField({ marks, value, kind = "time", told }: Needs) {
  const field = useRef<HTMLInputElement>(null);
  /** What is being typed and is no time yet. */
  const [typed, type] = useState<string>();
  useEffect(() => field.current ? withCalendar(field.current, kind) : undefined, [kind]);
  const hear = (text: string, left: boolean): void => {
    const whole = left || text === "" || isTime(text, kind);
    type(whole ? undefined : text);
    if (whole) told(text.trim());
  };
  return (
    <span class="when">
      <input {...marks} ref={field} autocomplete="off" spellcheck={false} maxLength={40} placeholder={LIKE[kind]} value={typed ?? value} onInput={(event) => hear(event.currentTarget.value, false)} onChange={(event) => hear(event.currentTarget.value, true)} />
    </span>
  );
}
