// Who goes by keyboard sees where they are. What gets the focus is scrolled to below what stays at the top; and where the page
// grows above it afterwards (a verdict that comes, an alarm), it is brought back into sight. Browsers hold the place only of what
// has been scrolled already. Nobody's own scrolling is ever undone: wheel, touch and the keys of scrolling end the watch, and so does
// any scroll that leaves the focus out of sight.

/** Keys that scroll wherever the focus is, and those that do so outside fields. */
const SCROLL = new Set(["PageUp", "PageDown"]);
const SCROLL_OUTSIDE = new Set(["ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight", "Home", "End", " "]);
/** A fraction of a pixel is nothing, px. */
const SLACK_PX = 1;

export function keepInSight(): void {
  const focus = new FocusWatch();
  const top = document.getElementById("top");
  if (!top) return;
  const { style } = document.documentElement;
  // Where only the bar stays, that counts.
  const height = (): number => (top.getClientRects().length ? top : (top.firstElementChild ?? top)).getBoundingClientRect().height;
  const watch = new ResizeObserver(() => {
    style.setProperty("--top-height", `${Math.round(height())}px`);
    focus.again();
  });
  watch.observe(top);
  for (const part of top.children) watch.observe(part);
}

/** Watches what has the focus by keyboard, until the person scrolls. */
class FocusWatch {
  private byKeys = false;
  private watched: Element | undefined;
  private observer: IntersectionObserver | undefined;

  constructor() {
    const passive = { capture: true, passive: true };
    document.addEventListener("keydown", (event) => this.key(event), passive);
    document.addEventListener("pointerdown", () => this.pointer(), passive);
    for (const name of ["wheel", "touchmove"]) document.addEventListener(name, () => this.end(), passive);
    document.addEventListener("scroll", ({ target }) => this.scrolled(target), passive);
    document.addEventListener("focusin", ({ target }) => this.begin(target));
    document.addEventListener("focusout", () => this.end());
  }

  /** What stays at the top became higher or lower. */
  again(): void {
    if (this.watched) this.begin(this.watched);
  }

  private begin(target: EventTarget | null): void {
    this.end();
    if (!this.byKeys || !(target instanceof Element) || !target.closest("main") || stays(target)) return;
    this.watched = target;
    const { top, bottom } = padding();
    this.observer = new IntersectionObserver((entries) => {
      const { intersectionRatio, boundingClientRect } = entries.at(-1) ?? {};
      // What takes no place is not there to be seen.
      if (intersectionRatio === undefined || intersectionRatio === 1 || !boundingClientRect?.height) return;
      target.scrollIntoView({ block: "nearest", inline: "nearest" });
    }, { threshold: [0, 1], rootMargin: `${-top}px 0px ${-bottom}px 0px` });
    this.observer.observe(target);
  }

  private end(): void {
    this.observer?.disconnect();
    this.observer = this.watched = undefined;
  }

  private key({ key, target }: KeyboardEvent): void {
    this.byKeys = true;
    const field = target instanceof HTMLElement && target.matches("input, select, textarea, button, summary, [contenteditable]");
    if (SCROLL.has(key) || (SCROLL_OUTSIDE.has(key) && !field)) this.end();
  }

  private pointer(): void {
    this.byKeys = false;
    this.end();
  }

  /** The browser scrolls to what gets the focus; who leads the person elsewhere leaves it out of sight. */
  private scrolled(scroller: EventTarget | null): void {
    const { watched } = this;
    if (!watched || !(scroller instanceof Node) || !scroller.contains(watched)) return;
    const inside = scroller instanceof Element ? scroller.getBoundingClientRect() : windowInside();
    if (isOutside(watched.getBoundingClientRect(), inside)) this.end();
  }
}

interface Sides {
  readonly top: number;
  readonly bottom: number;
  readonly left: number;
  readonly right: number;
}

/** Whether a part of it is out of sight; sideways that counts of what has room there. */
function isOutside({ top, bottom, left, right }: Sides, inside: Sides): boolean {
  if (top < inside.top - SLACK_PX || bottom > inside.bottom + SLACK_PX) return true;
  const fits = right - left <= inside.right - inside.left;
  return fits && (left < inside.left - SLACK_PX || right > inside.right + SLACK_PX);
}

/** Whether it stays where it is however far the page is scrolled. */
function stays(element: Element): boolean {
  for (let at: Element | null = element; at && at !== document.body; at = at.parentElement) if (/sticky|fixed/.test(getComputedStyle(at).position)) return true;
  return false;
}

/** What of the window others cover, above and below, px. */
function padding(): { top: number; bottom: number } {
  const { scrollPaddingTop, scrollPaddingBottom } = getComputedStyle(document.documentElement);
  return { top: Math.round(parseFloat(scrollPaddingTop) || 0), bottom: Math.round(parseFloat(scrollPaddingBottom) || 0) };
}

function windowInside(): Sides {
  const { top, bottom } = padding();
  return { top, bottom: innerHeight - bottom, left: 0, right: innerWidth };
}
