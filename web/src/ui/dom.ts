// Making elements; text is always set as text, whoever wrote it, and never without bounds.

import { tame } from "../state/foreign";

/** Letters of one text at most: beyond, nobody reads it here, and the page has to hold it. */
const MOST_LETTERS = 4_000;
/** What is read out or shown beside the pointer. */
const SPOKEN = new Set(["title", "aria-label", "alt", "placeholder"]);

type Attributes = Readonly<Record<string, string>>;

export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: readonly (Node | string)[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, bounded(name, value));
  element.append(...children.map((child) => (typeof child === "string" ? tame(child, MOST_LETTERS) : child)));
  return element;
}

/** Sets a text only when it changed, so that the browser has nothing to do when nothing happened. */
export function setText(element: Element, text: string): void {
  const tamed = tame(text, MOST_LETTERS);
  if (element.textContent !== tamed) element.textContent = tamed;
}

/** Sets or, with null, removes an attribute only when it changed. */
export function setAttribute(element: Element, name: string, value: string | null): void {
  const set = value === null ? null : bounded(name, value);
  if (element.getAttribute(name) === set) return;
  if (set === null) element.removeAttribute(name);
  else element.setAttribute(name, set);
}

function bounded(name: string, value: string): string {
  return SPOKEN.has(name) ? tame(value, MOST_LETTERS) : value;
}
