// Asking the server for JSON, and telling it to do something.

/** What the server said instead of an answer. */
export class Refusal extends Error {
  constructor(
    readonly status: number,
    readonly code: string,
    text: string,
    /** All that it said. */
    readonly answer?: unknown,
  ) {
    super(text);
  }
}

/** What to show for a question that failed. */
export function reason(error: unknown): string {
  if (error instanceof Refusal && error.status === 401) return "You are not logged in any more: this was not done. Log in again, here or in another tab.";
  if (error instanceof Refusal) return error.message;
  if (error instanceof DOMException && error.name === "TimeoutError") return "The server did not answer in time.";
  return "The server cannot be reached.";
}

export async function getJson<T>(path: string, signal?: AbortSignal): Promise<T> {
  const response = await fetch(path, { headers: { accept: "application/json" }, ...(signal ? { signal } : {}) });
  if (response.ok) return (await response.json()) as T;
  throw await refused(response);
}

/** Tells the server to do something, with the token that shows that one of its own pages asks. */
export async function postJson<T>(path: string, patienceMs: number, body?: unknown): Promise<T> {
  return tell<T>("POST", path, patienceMs, body);
}

/** Gives the server the whole of something anew. */
export async function putJson<T>(path: string, body: unknown, patienceMs: number): Promise<T> {
  return tell<T>("PUT", path, patienceMs, body);
}

/** Tells the server to take something away. */
export async function deleteAt(path: string, patienceMs: number): Promise<void> {
  await tell("DELETE", path, patienceMs);
}

async function tell<T>(method: string, path: string, patienceMs: number, body?: unknown): Promise<T> {
  const file = body instanceof Blob;
  const response = await fetch(path, {
    method,
    headers: {
      accept: "application/json",
      "x-csrf-token": csrf(),
      ...(body === undefined ? {} : { "content-type": file ? "application/octet-stream" : "application/json" }),
    },
    ...(body === undefined ? {} : { body: file ? body : JSON.stringify(body) }),
    signal: AbortSignal.timeout(patienceMs),
  });
  if (!response.ok) throw await refused(response);
  const text = await response.text();
  return (text ? JSON.parse(text) : undefined) as T;
}

/** The token against foreign pages. */
export function csrf(): string {
  return document.querySelector<HTMLMetaElement>('meta[name="csrf"]')?.content ?? "";
}

async function refused(response: Response): Promise<Refusal> {
  try {
    const answer = (await response.json()) as { error: { code: string; text: string } };
    return new Refusal(response.status, answer.error.code, answer.error.text, answer);
  } catch {
    return new Refusal(response.status, "unknown", `The server answered ${response.status}.`);
  }
}
