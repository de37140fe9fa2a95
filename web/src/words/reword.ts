// Texts that were said in English because their words had not come yet: where they stand on the page they are said again when
// these come. Parts of pages make texts once, when they are loaded, so what they write later is looked at too.

/** Texts that are remembered at most; a page says fewer. */
const MOST_TEXTS = 500;
/** A shorter text is only known where it stands alone: within others it may be part of a name. */
const LEAST_WITHIN = 10;
const SPOKEN = ["title", "aria-label", "placeholder"];

export class Reworder {
  private readonly texts = new Map<string, () => string>();
  private watch: MutationObserver | undefined;

  /** `text` was said in English; `again` says it with the words that are there then. */
  missed(text: string, again: () => string): void {
    if (text.trim() && this.texts.size < MOST_TEXTS) this.texts.set(text, again);
  }

  /** `text` with all in it said again that has words by now, the longest first: a text may stand within another. */
  said(text: string): string {
    let now = text;
    for (const [before, again] of [...this.texts].sort(([one], [other]) => other.length - one.length)) {
      if (now === before) now = again();
      else if (before.length >= LEAST_WITHIN && now.includes(before)) now = now.replaceAll(before, () => again());
    }
    return now;
  }

  /** Words came. */
  came(): void {
    const isLate = [...this.texts].some(([text, again]) => again() !== text);
    if (!isLate || typeof document === "undefined") return;
    this.reword(document.body);
    this.watch ??= new MutationObserver((changes) => {
      for (const { target, addedNodes } of changes) for (const node of [target, ...addedNodes]) this.reword(node);
    });
    this.watch.observe(document.body, { subtree: true, childList: true, characterData: true });
  }

  private reword(root: Node): void {
    const nodes = document.createTreeWalker(root, NodeFilter.SHOW_TEXT | NodeFilter.SHOW_ELEMENT);
    for (let node: Node | null = root; node; node = nodes.nextNode()) {
      if (node instanceof Text) this.rewordText(node);
      else if (node instanceof Element) this.rewordSpoken(node);
    }
  }

  private rewordText(node: Text): void {
    const now = this.said(node.data);
    if (now !== node.data) node.data = now;
  }

  private rewordSpoken(element: Element): void {
    for (const name of SPOKEN) {
      const text = element.getAttribute(name);
      const now = text === null ? null : this.said(text);
      if (now !== null && now !== text) element.setAttribute(name, now);
    }
  }
}
