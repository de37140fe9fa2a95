// What tells this tab from others of the same person, through reloading and from page to page.

const KEY = "lutra-window";

let mine: string | undefined;

/**
 * The tab's own key. A tab that is duplicated gets a copy of the browser's storage for it; the key therefore lies there
 * only while no page is open in the tab.
 */
export function windowKey(): string {
  mine ??= taken() ?? newKey();
  return mine;
}

function taken(): string | null {
  const known = sessionStorage.getItem(KEY);
  sessionStorage.removeItem(KEY);
  window.addEventListener("pagehide", () => mine && sessionStorage.setItem(KEY, mine));
  window.addEventListener("pageshow", () => sessionStorage.removeItem(KEY));
  return known;
}

/** A key that nobody else makes. */
export function newKey(): string {
  return [...crypto.getRandomValues(new Uint8Array(12))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}
