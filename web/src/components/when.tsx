// A field of a time or a day: typed, or chosen in the browser's calendar.

import { useEffect, useRef, useState } from "preact/hooks";
import { isTime } from "../state/takeout";
import { LIKE, type When, withCalendar } from "../ui/when";

interface Needs {
  readonly marks: { readonly id: string; readonly "aria-invalid": boolean; readonly "aria-describedby": string };
  readonly value: string;
  readonly kind?: When;
  /** Called with each whole time at once, and with any text when the field is left. */
  changed(text: string): void;
}

export function WhenField({ marks, value, kind = "time", changed }: Needs) {
  const field = useRef<HTMLInputElement>(null);
  /** Text that is being typed and is not a time yet. */
  const [typed, type] = useState<string>();
  useEffect(() => field.current ? withCalendar(field.current, kind) : undefined, [kind]);
  const typing = (text: string, left: boolean): void => {
    const whole = left || text === "" || isTime(text, kind);
    type(whole ? undefined : text);
    if (whole) changed(text.trim());
  };
  return (
    <span class="when">
      <input {...marks} ref={field} autocomplete="off" spellcheck={false} maxLength={40} placeholder={LIKE[kind]} value={typed ?? value} onInput={(event) => typing(event.currentTarget.value, false)} onChange={(event) => typing(event.currentTarget.value, true)} />
    </span>
  );
}
