// Draws components at once, so that what fails is known where it was asked for, and the page greys and says so.

import { type ComponentChild, render } from "preact";

export function createMount(root: HTMLElement): (what: ComponentChild) => void {
  let box = document.createElement("div");
  box.className = "mount";
  root.append(box);
  return (what) => {
    try {
      render(what, box);
    } catch (error) {
      // Half of a drawing is no ground for the next one.
      const next = document.createElement("div");
      next.className = "mount";
      box.replaceWith(next);
      box = next;
      throw error;
    }
  };
}
