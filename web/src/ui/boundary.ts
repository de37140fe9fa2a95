// What happens when the page itself fails: no part of it may go on showing old values as if they were fresh.

/** Browsers tell of this as an error; it only means that a size is looked at once more with the next picture. */
const HARMLESS = /^ResizeObserver loop/;

export interface Boundary {
  /** Draws a part that is drawn whole each time. One that fails is known as failed until it is drawn well again. */
  draw(part: string, work: () => void): void;
  /** Takes in what is told once only. Where that fails, the page stays failed until it is loaded again. */
  take(part: string, work: () => void): void;
  /** Whether what is shown cannot be relied on. */
  failed(): boolean;
}

/** `changed` is called when that changes. What fails outside of any part stays failed as well. */
export function createBoundary(changed: () => void): Boundary {
  const parts = new Set<string>();
  let script = false;
  const fail = (): void => {
    if (script) return;
    script = true;
    changed();
  };
  const failedIn = (part: string, error: unknown): boolean => {
    if (parts.has(part)) return false;
    parts.add(part);
    // Told once, however often it comes.
    console.error(`"${part}" of this page failed`, error);
    return true;
  };
  window.addEventListener("error", (event) => {
    // What an extension of the browser does wrong is no fault of this page.
    const ours = !event.filename || event.filename.startsWith(location.origin);
    if (ours && !HARMLESS.test(event.message)) fail();
  });
  window.addEventListener("unhandledrejection", fail);
  return {
    draw(part, work) {
      try {
        work();
        if (parts.delete(part)) changed();
      } catch (error) {
        if (failedIn(part, error)) changed();
      }
    },
    take(part, work) {
      try {
        work();
      } catch (error) {
        if (failedIn(part, error)) fail();
      }
    },
    failed: () => script || parts.size > 0,
  };
}
