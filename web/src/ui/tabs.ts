// Tabs by the book: arrows move between them, only the shown one is in the tab order.

import { make, setAttribute } from "./dom";

export interface Tabs {
  /** Whether this one is in sight. */
  shows(name: string): boolean;
  open(name: string): void;
}

/** Puts panels under tabs in `root`, each with its words; `changed` is told when another is shown. */
export function createTabs(root: HTMLElement, label: string, panels: readonly (readonly [string, HTMLElement])[], words: Readonly<Record<string, string>>, changed: (name: string) => void): Tabs {
  const bar = make("div", { role: "tablist", "aria-label": label, class: "tabs" });
  let shown = panels[0]?.[0] ?? "";
  const tabs = new Map<string, HTMLButtonElement>();
  const open = (name: string): void => {
    shown = name;
    for (const [one, panel] of panels) {
      const tab = tabs.get(one);
      if (tab) {
        setAttribute(tab, "aria-selected", String(one === name));
        setAttribute(tab, "tabindex", one === name ? "0" : "-1");
      }
      setAttribute(panel, "hidden", one === name ? null : "");
    }
    changed(name);
  };
  panels.forEach(([name, panel], index) => {
    const id = `tab-${index}`;
    const tab = make("button", { type: "button", role: "tab", id, "aria-controls": `panel-${index}` }, words[name] ?? name);
    tab.addEventListener("click", () => open(name));
    tab.addEventListener("keydown", (event) => {
      const by = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
      const next = panels[(index + by + panels.length) % panels.length]?.[0];
      if (!by || next === undefined) return;
      event.preventDefault();
      open(next);
      tabs.get(next)?.focus();
    });
    for (const [key, value] of Object.entries({ role: "tabpanel", id: `panel-${index}`, "aria-labelledby": id })) panel.setAttribute(key, value);
    tabs.set(name, tab);
    bar.append(tab);
    root.append(panel);
  });
  root.prepend(bar);
  open(shown);
  return { shows: (name) => name === shown, open };
}
