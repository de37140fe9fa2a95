// A step that cannot be undone: it is asked back in its place. The browser's own question would hold the whole page, STOP
// included, until it is answered.

import { useEffect, useId, useRef, useState } from "preact/hooks";
import { t } from "../words/words";

export interface TwoStepProps {
  /** What the button says, and again the one that does it. */
  readonly word: string;
  /** What the button says to those who hear it, where the word alone does not tell which it is. */
  readonly label?: string;
  readonly kind: "main" | "danger";
  readonly question: string;
  readonly busy?: boolean;
  act(): void;
}

export function TwoStep({ word, label, kind, question, busy = false, act }: TwoStepProps) {
  const [asked, ask] = useState(false);
  const [id, words, button] = [useId(), useRef<HTMLParagraphElement>(null), useRef<HTMLButtonElement>(null)];
  const wasAsked = useRef(false);
  useEffect(() => {
    // The words get the focus, not the button: a stray key does nothing.
    if (asked) words.current?.focus();
    else if (wasAsked.current) button.current?.focus();
    wasAsked.current = asked;
  }, [asked]);
  // What the page is about is its one main button; this one becomes main with its question.
  if (!asked) return <button ref={button} type="button" class={kind === "danger" ? kind : undefined} aria-label={label} aria-disabled={busy} onClick={() => !busy && ask(true)}>{word}</button>;
  const leave = (event: KeyboardEvent): void => {
    if (event.key !== "Escape") return;
    event.preventDefault();
    ask(false);
  };
  const go = (): void => {
    ask(false);
    act();
  };
  return (
    <div class="confirm" role="group" aria-labelledby={id} onKeyDown={leave}>
      <p ref={words} id={id} tabIndex={-1}>{question}</p>
      <div class="row"><button type="button" onClick={() => ask(false)}>{t("Cancel")}</button><button type="button" class={kind} onClick={go}>{word}</button></div>
    </div>
  );
}
