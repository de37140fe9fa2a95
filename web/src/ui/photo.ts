// Photos as phones make them are larger than a link at sea and the server take: they are made smaller before they are sent.

import { inEnglish, putJson, reason } from "../api/http";
import type { LogNote } from "../api/types.gen";
import { fieldOf, PHOTO_BYTES, type Wrong } from "../state/notes";
import { t } from "../words/words";

/** A photo that has more bytes is made smaller. */
const LARGE_BYTES = 1_500_000;
/** The longer side of one that was made smaller, pixels. */
const SIDE = 2_048;
const QUALITY = 0.85;
/** Photos go by slow links. */
const PATIENCE_MS = 120_000;

/** Gives a note its photo; throws what `wrongFrom` tells. */
export async function sendPhoto(note: LogNote, photo: File): Promise<LogNote> {
  return putJson<LogNote>(`/api/v1/logbook/${note.id}/photo`, await smaller(photo), PATIENCE_MS);
}

/** What failed, at the field that it is about. */
export function wrongFrom(error: unknown): Wrong {
  return error instanceof TooLarge ? { field: "photo", text: error.message } : fieldOf(reason(error), inEnglish(error));
}

class TooLarge extends Error {}

/** The photo as it is sent. */
async function smaller(file: File): Promise<Blob> {
  if (file.size <= LARGE_BYTES) return file;
  const small = await drawn(file).catch(() => null);
  const best = small && small.size < file.size ? small : file;
  if (best.size > PHOTO_BYTES) throw new TooLarge(t("This photo has more than 4 MB and cannot be made smaller here. Choose a smaller one."));
  return best;
}

async function drawn(file: File): Promise<Blob | null> {
  const image = await createImageBitmap(file);
  const factor = Math.min(1, SIDE / Math.max(image.width, image.height));
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [Math.round(image.width * factor), Math.round(image.height * factor)];
  canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
  image.close();
  return new Promise((done) => canvas.toBlob(done, "image/jpeg", QUALITY));
}
