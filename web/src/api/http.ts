// Asking the server for JSON, and telling it to do something.

/** What the server said instead of an answer. */
export class Refusal extends Error {
  constructor(
    readonly status: number,
    readonly code: string,
    text: string,
  ) {
    super(text);
  }
}

/** What to show for a question that failed. */
export function reason(error: unknown): string {
  if (error instanceof Refusal) return error.message;
  if (error instanceof DOMException && error.name === "TimeoutError") return "The server did not answer in time.";
  return "The server cannot be reached.";
}

export async function getJson<T>(path: string, signal?: AbortSignal): Promise<T> {
  const response = await fetch(path, { headers: { accept: "application/json" }, ...(signal ? { signal } : {}) });
  if (response.ok) return (await response.json()) as T;
  const { code, text } = await refusal(response);
  throw new Refusal(response.status, code, text);
}

/** Tells the server to do something, with the token that shows that one of its own pages asks. */
export async function postJson<T>(path: string, patienceMs: number, body?: unknown): Promise<T> {
  const response = await fetch(path, {
    method: "POST",
    headers: { accept: "application/json", "x-csrf-token": csrf(), ...(body === undefined ? {} : { "content-type": "application/json" }) },
    ...(body === undefined ? {} : { body: JSON.stringify(body) }),
    signal: AbortSignal.timeout(patienceMs),
  });
  if (response.ok) return (await response.json()) as T;
  const { code, text } = await refusal(response);
  throw new Refusal(response.status, code, text);
}

/** The token against foreign pages. */
export function csrf(): string {
  return document.querySelector<HTMLMetaElement>('meta[name="csrf"]')?.content ?? "";
}

async function refusal(response: Response): Promise<{ code: string; text: string }> {
  try {
    return ((await response.json()) as { error: { code: string; text: string } }).error;
  } catch {
    return { code: "unknown", text: `The server answered ${response.status}.` };
  }
}
