// One signal that ends with any of several. STOP must not depend on `AbortSignal.any`, which browsers have since 2023 or 2024.

export function anyOf(...signals: readonly AbortSignal[]): AbortSignal {
  if (typeof AbortSignal.any === "function") return AbortSignal.any([...signals]);
  const ends = new AbortController();
  for (const one of signals) {
    if (one.aborted) ends.abort(one.reason);
    else one.addEventListener("abort", () => ends.abort(one.reason), { once: true, signal: ends.signal });
  }
  return ends.signal;
}
