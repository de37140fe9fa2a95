// Whether the vessel is ready to sail, above the list of its parts.

import type { Readiness } from "../state/readiness";
import { t } from "../words/words";

/** A shape beside the colour. */
const SHAPES: Readonly<Record<string, string>> = { good: "●", unknown: "○", starting: "◔", attention: "▲", bad: "◆" };

export function ReadinessList({ grade, verdict, remarks }: Readiness) {
  return (
    <section class="readiness" data-grade={grade} aria-label={t("Ready to sail?")}>
      <h3><span class="shape" aria-hidden="true">{SHAPES[grade]}</span> {verdict}</h3>
      {remarks.length > 0 && (
        <ul>
          {remarks.map(({ part, grade, says }) => (
            <li key={part} data-grade={grade}><span class="shape" aria-hidden="true">{SHAPES[grade]}</span> <strong>{part}</strong>: {says}</li>
          ))}
        </ul>
      )}
    </section>
  );
}
