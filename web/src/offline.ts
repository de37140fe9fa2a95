// On the page that says that the server is not reached: opens the page that was asked for once it is.

const AGAIN_MS = 5_000;
/** A request that takes longer stands for no link. */
const PATIENCE_MS = 4_000;

async function look(): Promise<void> {
  try {
    await fetch("/healthz", { signal: AbortSignal.timeout(PATIENCE_MS), cache: "no-store" });
    location.reload();
  } catch {
    window.setTimeout(() => void look(), AGAIN_MS);
  }
}
void look();
