// The legend of tags: each with its colour and how often it was heard, and whether it is shown.

import { signal, type Signal } from "@preact/signals";
import { useState } from "preact/hooks";
import { type TagCount, tagsFound, tagSeries, withHidden } from "../state/tags";
import { t } from "../words/words";

/** What somebody left out stays out while this window is open, on each of its pages. */
const KEPT = "lutra.tags.hidden";
/** With more tags than this they can be looked for. */
const FEW = 8;

/** The names of tags that are left out of maps, times and tables. */
export type HiddenTags = Signal<ReadonlySet<string>>;

/** As this window's person left them; what they change is kept. */
export function keptHiddenTags(): HiddenTags {
  const hidden = signal<ReadonlySet<string>>(kept());
  hidden.subscribe((now) => sessionStorage.setItem(KEPT, JSON.stringify([...now])));
  return hidden;
}

function kept(): ReadonlySet<string> {
  try {
    const names: unknown = JSON.parse(sessionStorage.getItem(KEPT) ?? "[]");
    return new Set(Array.isArray(names) ? names.filter((name) => typeof name === "string") : []);
  } catch {
    return new Set();
  }
}

export function TagLegend({ tags, hidden }: { readonly tags: readonly TagCount[]; readonly hidden: HiddenTags }) {
  const [words, look] = useState("");
  const listed = tagsFound(tags, words);
  const names = listed.map(({ tag }) => tag);
  const set = (some: readonly string[], out: boolean): void => {
    hidden.value = withHidden(hidden.value, some, out);
  };
  const shown = tags.filter(({ tag }) => !hidden.value.has(tag)).length;
  return (
    <div class="tag-legend">
      {tags.length > FEW && <input type="search" aria-label={t("Find a tag")} placeholder="S256-101" autocomplete="off" spellcheck={false} value={words} onInput={(event) => look(event.currentTarget.value)} />}
      <ul class="legend-tags" aria-label={t("Tags, and how often they were heard")}>
        {listed.map(({ tag, id, count }) => (
          <li key={tag}><label class="inline"><input type="checkbox" checked={!hidden.value.has(tag)} onChange={() => set([tag], !hidden.value.has(tag))} /><span data-tag={tagSeries(id)}>{tag}</span> <span class="dim num">{count}</span></label></li>
        ))}
      </ul>
      {listed.length === 0 && <p class="dim">{t("No matching tags.")}</p>}
      <p class="row">
        <button type="button" disabled={names.every((tag) => !hidden.value.has(tag))} onClick={() => set(names, false)}>{t("All tags")}</button>
        <button type="button" disabled={names.every((tag) => hidden.value.has(tag))} onClick={() => set(names, true)}>{t("No tags")}</button>
        <span class="dim num" role="status">{shown < tags.length ? t("{shown} of {all} shown", { shown, all: tags.length }) : ""}</span>
      </p>
    </div>
  );
}
