// Asking the server for JSON, and telling it to do something.

import { plainRefusal } from "../state/plainrefusal";
import { later, t, withWords } from "../words/words";
import { anyOf } from "./signal";
import { inTurn, question, type Rank } from "./traffic";
import type { Ordered, Refusal as RefusalAnswer, RefusalReason } from "./types.gen";

/** What the server said instead of an answer. */
export class Refusal extends Error {
  constructor(
    readonly status: number,
    /** Why, by code and parameters. */
    readonly why: RefusalReason,
    /** All that it said. */
    readonly answer?: unknown,
    /** After so long it may be asked again, s; 0 where it did not say so. */
    readonly waitS = 0,
    text = plainRefusal(why),
  ) {
    super(text);
  }

  get code(): string {
    return this.why.code;
  }
}

/** What to show for a question that failed. */
export function reason(error: unknown): string {
  if (error instanceof Refusal && error.status === 401) return t("You are not logged in any more: this was not done. Log in again, here or in another tab.");
  if (error instanceof Refusal) return error.message;
  if (error instanceof DOMException && error.name === "TimeoutError") return t("The server did not answer in time.");
  return t("The server cannot be reached.");
}

/** The same as the server said it in English, which names the field that it is about; empty for what it did not say. */
export function inEnglish(error: unknown): string {
  return error instanceof Refusal ? error.why.text : "";
}

export function getJson<T>(path: string, signal?: AbortSignal): Promise<T> {
  return get("ask", path, async (response) => (await response.json()) as T, signal);
}

/** A text as it is. */
export function getText(path: string, signal?: AbortSignal): Promise<string> {
  return get("ask", path, (response) => response.text(), signal);
}

/** The bytes of something that is drawn, after all that is asked. */
export function getTile(path: string): Promise<ArrayBuffer> {
  return get("tile", path, (response) => response.arrayBuffer());
}

function get<T>(rank: Rank, path: string, read: (response: Response) => Promise<T>, signal?: AbortSignal): Promise<T> {
  return question(
    rank,
    path,
    async (response) => {
      if (response.ok) return read(response);
      throw await refused(response);
    },
    signal,
  );
}

/** Tells the server to do something, with the token that shows that one of its own pages asks; `left` ends it early. */
export async function postJson<T>(path: string, patienceMs: number, body?: unknown, left?: AbortSignal): Promise<T> {
  return tell<T>("POST", path, patienceMs, body, left);
}

/** Gives the server the whole of something again. */
export async function putJson<T>(path: string, body: unknown, patienceMs: number): Promise<T> {
  return tell<T>("PUT", path, patienceMs, body);
}

/** Has the server change a part of something. */
export async function patchJson<T>(path: string, body: unknown, patienceMs: number): Promise<T> {
  return tell<T>("PATCH", path, patienceMs, body);
}

/** Tells the server to take something away. */
export async function deleteAt(path: string, patienceMs: number): Promise<void> {
  await tell("DELETE", path, patienceMs);
}

/** Sends a form as the browser itself would, without leaving the page. */
export async function postForm(path: string, fields: URLSearchParams, patienceMs: number): Promise<void> {
  const signal = AbortSignal.timeout(patienceMs);
  await inTurn("act", signal, () => fetch(path, { method: "POST", body: fields, redirect: "manual", signal }));
}

/** A stop that nobody answered is not sent any more after so long: hours later a person presses again, ms. */
export const STOP_WANTED_MS = 600_000;

/** STOP waits for no turn: all others leave it a connection. `signal` ends the try. */
export async function postStop(vessel: number, window: string, key: string, signal: AbortSignal): Promise<Ordered> {
  const query = new URLSearchParams({ window, key });
  return sent<Ordered>("POST", `/api/v1/vessels/${vessel}/abort?${query}`, signal, undefined, "at hand");
}

async function tell<T>(method: string, path: string, patienceMs: number, body?: unknown, left?: AbortSignal): Promise<T> {
  const patience = AbortSignal.timeout(patienceMs);
  const signal = left ? anyOf(patience, left) : patience;
  return inTurn("act", signal, () => sent<T>(method, path, signal, body));
}

/** `words` of a refusal: those that may have to be fetched, or at once with what is at hand. */
async function sent<T>(method: string, path: string, signal: AbortSignal, body?: unknown, words: "all" | "at hand" = "all"): Promise<T> {
  const file = body instanceof Blob;
  const response = await fetch(path, {
    method,
    headers: {
      accept: "application/json",
      "x-csrf-token": csrf(),
      ...(body === undefined ? {} : { "content-type": file ? "application/octet-stream" : "application/json" }),
    },
    ...(body === undefined ? {} : { body: file ? body : JSON.stringify(body) }),
    signal,
  });
  if (!response.ok) throw await refused(response, words);
  const text = await response.text();
  return (text ? JSON.parse(text) : undefined) as T;
}

/** The token against foreign pages. */
export function csrf(): string {
  return document.querySelector<HTMLMetaElement>('meta[name="csrf"]')?.content ?? "";
}

async function refused(response: Response, words: "all" | "at hand" = "all"): Promise<Refusal> {
  const waitS = Number(response.headers.get("retry-after")) || 0;
  try {
    const answer = (await response.json()) as RefusalAnswer;
    if (words === "all") await withWords(answer.error.says);
    return new Refusal(response.status, answer.error, answer, waitS, await guardText(answer.error));
  } catch {
    return new Refusal(response.status, { code: "unknown", text: t("The server answered {status}.", { status: response.status }) });
  }
}

/** What the chart has against it; its words are loaded when they are first needed. Undefined where the chart refused nothing. */
async function guardText(why: RefusalReason): Promise<string | undefined> {
  if (!why.guard) return undefined;
  try {
    return (await later(() => import("../state/refusal"))).refusalText(why);
  } catch {
    return why.text;
  }
}
