// Asking the server for JSON.

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

export async function getJson<T>(path: string): Promise<T> {
  const response = await fetch(path, { headers: { accept: "application/json" } });
  if (response.ok) return (await response.json()) as T;
  const { code, text } = await refusal(response);
  throw new Refusal(response.status, code, text);
}

async function refusal(response: Response): Promise<{ code: string; text: string }> {
  try {
    const body = (await response.json()) as { error: { code: string; text: string } };
    return body.error;
  } catch {
    return { code: "unknown", text: `The server answered ${response.status}.` };
  }
}
