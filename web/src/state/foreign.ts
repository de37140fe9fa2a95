// Text that vessels, logs and files bring: what of it may stand on a page. Pure.

/** Letters of a system's name at most: it stands on buttons. */
const MOST_NAME = 32;
/** What a long name keeps of its end, where names often differ. */
const NAME_END = 12;

/** Control characters, which have no picture of their own; line ends and tabs are spaces to a page. */
const CONTROLS = /[\u0000-\u0008\u000b\u000c\u000e-\u001f\u007f-\u009f]/g;
/** Letters that turn the direction of what is read, or that nobody sees: a text with them looks like another. */
const UNSEEN = /[\u00ad\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb]/g;
/** Marks that pile up over a letter until they cover the lines around it. */
const PILED = /(\p{M}{3})\p{M}+/gu;
const UNTAMED = /[\u0000-\u0008\u000b\u000c\u000e-\u001f\u007f-\u009f\u00ad\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb]|\p{M}{4}/u;

/** Nothing but letters, figures and signs that stand beside each other: what nearly all texts are, told quickly. */
const PLAIN = /^[\t\n\r -~\u00a0-\u00ac\u00ae-\u02ff\u2010-\u2027\u2030-\u205e\u2190-\u25ff]*$/;

/** A text with `most` letters at most, in which all that is there can be seen. */
export function tame(text: string, most: number): string {
  if (text.length <= most && PLAIN.test(text)) return text;
  const cut = text.length > most ? `${whole(text.slice(0, most - 1))}…` : text;
  return UNTAMED.test(cut) ? cut.replace(CONTROLS, "\ufffd").replace(UNSEEN, "").replace(PILED, "$1") : cut;
}

/** A system's name on one short line. A long one keeps its end, where names often differ. */
export function named(name: string): string {
  const line = tame(name.slice(0, 10 * MOST_NAME), 10 * MOST_NAME).replace(/\s+/g, " ").trim();
  const letters = [...line];
  if (letters.length <= MOST_NAME) return line;
  const end = [...tame(name.slice(-10 * MOST_NAME), 10 * MOST_NAME).replace(/\s+/g, " ").trim()].slice(-NAME_END);
  return `${letters.slice(0, MOST_NAME - 1 - NAME_END).join("")}…${end.join("")}`;
}

/** Without half of a letter that has two code units. */
function whole(text: string): string {
  return /[\ud800-\udbff]$/.test(text) ? text.slice(0, -1) : text;
}
