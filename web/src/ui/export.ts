// Fills the CSV form with what the history holds. The form itself works without this.

import { getJson } from "../api/http";
import type { Recorded } from "../api/types.gen";
import { make, setText } from "./dom";

/** Offers the messages that were recorded and the last hour. */
export async function fillExport(form: HTMLFormElement): Promise<void> {
  const note = form.querySelector("[data-note]");
  const [from, to] = [form.elements.namedItem("from"), form.elements.namedItem("to")];
  const iso = (ms: number): string => `${new Date(ms).toISOString().slice(0, 19)}Z`;
  if (from instanceof HTMLInputElement && !from.value) from.value = iso(Date.now() - 3_600_000);
  if (to instanceof HTMLInputElement) to.placeholder = "now";
  try {
    const recorded = await getJson<Recorded[]>("/api/v1/recorded");
    const names = [...new Set(recorded.map((series) => series.abbrev))].sort();
    form.querySelector("datalist")?.replaceChildren(...names.map((name) => make("option", { value: name })));
    if (note) setText(note, names.length ? "" : "Nothing is recorded yet.");
  } catch (error) {
    if (note) setText(note, error instanceof Error ? error.message : String(error));
  }
}
