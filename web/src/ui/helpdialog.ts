// What the help shows: keys of the page and words of the field, and a search in both.

import { GLOSSARY, KEYS } from "../state/helpwords";
import { t } from "../words/words";
import { make } from "./dom";

/** Puts it into the dialog, which may be open already. */
export function fillHelp(dialog: HTMLDialogElement): void {
  const search = make("input", { type: "text", "aria-label": t("Search in help"), placeholder: t("Search") });
  // In the order of the page's language, whose last letters are æ, ø and å.
  const sorted = [...GLOSSARY].sort(([one], [other]) => one.localeCompare(other, document.documentElement.lang));
  const terms = sorted.map(([term, meaning]) => ({ text: `${term} ${meaning}`.toLowerCase(), row: make("div", {}, make("dt", {}, term), make("dd", {}, meaning)) }));
  const here = KEYS.filter(({ where }) => where === "" || document.querySelector(where));
  const keys = here.map(({ keys, does }) => ({ text: `${keys} ${does}`.toLowerCase(), row: make("div", {}, make("dt", {}, ...keys.split(" ").map((key) => make("kbd", {}, key))), make("dd", {}, does)) }));
  const none = make("p", { hidden: "" }, t("No matching help topics."));
  const [ofKeys, ofTerms] = [make("h3", {}, t("Keys on this page")), make("h3", {}, t("Words"))];
  search.addEventListener("input", () => {
    const wanted = search.value.trim().toLowerCase();
    for (const { text, row } of [...terms, ...keys]) row.hidden = !text.includes(wanted);
    ofKeys.hidden = keys.every(({ row }) => row.hidden);
    ofTerms.hidden = terms.every(({ row }) => row.hidden);
    none.hidden = !ofKeys.hidden || !ofTerms.hidden;
  });
  const close = make("button", { type: "button" }, t("Close"));
  // While it was read the person may have gone elsewhere, such as to STOP.
  const isHere = dialog.contains(document.activeElement);
  dialog.replaceChildren(
    make("div", { class: "row" }, make("h2", { id: "help-title" }, t("Help")), search, close),
    make("p", {}, make("a", { href: "/help" }, t("The manual: guides, and what to do about each alarm"))),
    none,
    ofKeys, make("dl", { class: "keys" }, ...keys.map(({ row }) => row)),
    ofTerms, make("dl", {}, ...terms.map(({ row }) => row)));
  close.addEventListener("click", () => dialog.close());
  if (isHere) search.focus();
}
