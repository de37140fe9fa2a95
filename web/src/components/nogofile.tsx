// No-go areas from a GeoJSON file: what it would close is shown first, then all are closed together.

import { signal } from "@preact/signals";
import type { NoGoAreaRequest } from "../api/types.gen";
import { type AreasOfFile, areasOfGeoJson } from "../state/nogo";
import { sendingText } from "../state/sending";
import { t } from "../words/words";

/** Bytes of a file that is read. */
const MOST_BYTES = 4 * 2 ** 20;
/** Names that are told of a file. */
const MOST_TOLD = 12;

interface Needs {
  /** Closes all of them; why none was, or nothing where it is done. `waits` is told where nobody answers and it is tried again. */
  close(areas: readonly NoGoAreaRequest[], waits: (tries: number) => void): Promise<string>;
  /** How many more can be closed. */
  room(): number;
}

/** Makes the button and what it opens; the state stays over new drawings. */
export function createNoGoFile({ close, room }: Needs) {
  const read = signal<AreasOfFile | undefined>(undefined);
  const busy = signal(false);
  const tries = signal(0);
  const failed = signal("");

  const choose = async (input: HTMLInputElement): Promise<void> => {
    const [file] = input.files ?? [];
    if (!file) return;
    failed.value = "";
    const tooLarge = { areas: [], wrong: t("The file is larger than {most} MB: take out what is not needed.", { most: MOST_BYTES / 2 ** 20 }) };
    const found = file.size > MOST_BYTES ? tooLarge : areasOfGeoJson(await file.text(), file.name.replace(/\.\w+$/, ""));
    const count = found.areas.length;
    read.value = count > room() ? { areas: [], wrong: t("The file has {count} areas; {room} more can be closed.", { count, room: room() }) } : found;
    // The same file can be chosen again after it was mended.
    input.value = "";
  };
  const bringIn = async (areas: readonly NoGoAreaRequest[]): Promise<void> => {
    [failed.value, busy.value, tries.value] = ["", true, 0];
    failed.value = await close(areas, (count) => (tries.value = count));
    busy.value = false;
    if (!failed.value) read.value = undefined;
  };
  return function NoGoFile() {
    const found = read.value;
    const count = found?.areas.length ?? 0;
    return (
      <section aria-label={t("Areas from a file")}>
        <p class="row"><label class="button">{t("Import GeoJSON …")}<input class="hidden" type="file" accept=".geojson,.json,application/geo+json" disabled={busy.value} onChange={(event) => void choose(event.currentTarget)} /></label></p>
        {found?.wrong && <p class="note bad" role="alert">{found.wrong}</p>}
        {failed.value && <p class="note bad" role="alert">{failed.value}</p>}
        {count > 0 && (
          <>
            <p role="status">{busy.value ? sendingText(tries.value) : t("{n} areas to be closed: {names}", { n: count, names: names(found?.areas ?? []) })}</p>
            <p class="row">
              <button type="button" class="main" disabled={busy.value} onClick={() => void bringIn(found?.areas ?? [])}>{t("Close these areas")}</button>
              <button type="button" disabled={busy.value} onClick={() => (read.value = undefined)}>{t("Cancel")}</button>
            </p>
          </>
        )}
      </section>
    );
  };
}

function names(areas: readonly NoGoAreaRequest[]): string {
  const told = areas.slice(0, MOST_TOLD).map(({ name }) => name).join(", ");
  return areas.length > MOST_TOLD ? `${told}, …` : told;
}
