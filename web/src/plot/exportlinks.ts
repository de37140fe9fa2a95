// The links under a plot that give what it shows as CSV.

import { make, setAttribute, setText } from "../ui/dom";
import { type Companion, exports, type Line } from "./model";
import { t } from "../words/words";

/** What a plot shows: lines of the page's vessel, and of others beside it. */
export interface Exported {
  readonly vessel: number;
  readonly lines: readonly Line[];
  readonly beside: readonly { readonly line: Line; readonly companion: Companion }[];
}

/** Brings the links in `box` up to date for the time from `fromUs` to `toUs`, µs since 1970 UTC. */
export function drawExports(box: HTMLElement, { vessel, lines, beside }: Exported, companions: readonly Companion[], fromUs: number, toUs: number): void {
  const links = exports(vessel, lines.map(({ source }) => source), fromUs, toUs);
  for (const companion of companions) {
    const theirs = beside.filter((one) => one.companion === companion).map(({ line }) => line.source);
    links.push(...exports(companion.address, theirs, fromUs, toUs).map(({ name, href }) => ({ name: `${companion.name} ${name}`, href })));
  }
  while (box.children.length > links.length) box.lastElementChild?.remove();
  links.forEach(({ name, href }, index) => {
    const link = box.children[index] ?? box.appendChild(make("a", { class: "button", download: "" }));
    const text = links.length > 1 ? t("CSV {index}", { index: index + 1 }) : "CSV";
    setText(link, text);
    setAttribute(link, "href", href);
    // What is read aloud begins with what is seen.
    setAttribute(link, "aria-label", `${links.length > 1 ? `${text}: ` : ""}${t("Download CSV of {name} as shown", { name })}`);
  });
}
