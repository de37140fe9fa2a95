// Uploading logs, one after the other, and how far the server is with reading them.

import { csrf, getJson, postJson, reason } from "../api/http";
import { inTurn } from "../api/traffic";
import type { Import, Recorded } from "../api/types.gen";
import { make, setText } from "../ui/dom";
import { hexAddress, utc } from "../ui/format";
import { IMPORT_STATES } from "../state/imports";
import { t, tn, withWords, worded } from "../words/words";

/** The server is asked how far it is so often, ms. */
const AGAIN_MS = 1_000;
/** So long it may take to answer that an import is to end, ms. */
const CANCEL_MS = 5_000;

export function startImport(form: HTMLFormElement): void {
  const field = form.elements.namedItem("files");
  const of = form.elements.namedItem("vessel");
  const shown = document.getElementById("imports");
  const button = form.querySelector("button");
  if (!(field instanceof HTMLInputElement) || !shown || !button) return;
  const sending = make("div", { class: "sending", role: "status" });
  form.append(sending);
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const files = [...(field.files ?? [])];
    const vessel = of instanceof HTMLInputElement ? of.value.trim() : "";
    button.disabled = true;
    void (async () => {
      for (const file of files) await send(file, vessel, sending);
      button.disabled = false;
      form.reset();
      await list(shown);
    })();
  });
  const recorded = make("ul", {});
  shown.parentElement?.after(make("section", { "aria-labelledby": "h-recorded" }, make("h2", { id: "h-recorded" }, t("Recorded vessels")), recorded));
  const again = async (): Promise<void> => {
    await Promise.all([list(shown), watchable(recorded)]);
    window.setTimeout(() => void again(), AGAIN_MS);
  };
  void again();
}

/** Tables of detections; a log says itself which vessels it is of. */
const TABLE = /\.(csv|txt|parquet)$/i;

/** Uploads a file; resolves when the server has it or has refused it. */
function send(file: File, vessel: string, root: HTMLElement): Promise<void> {
  const bar = make("progress", { max: "1", value: "0", "aria-label": t("Upload of {name}", { name: file.name }) });
  const text = make("span", {}, t("{name}: uploading …", { name: file.name }));
  root.append(make("p", { class: "row" }, text, bar));
  const never = new AbortController().signal;
  return inTurn("act", never, () => new Promise((done) => {
    const request = new XMLHttpRequest();
    request.open("POST", `/api/v1/import?name=${encodeURIComponent(file.name)}${vessel && TABLE.test(file.name) ? `&vessel=${encodeURIComponent(vessel)}` : ""}`);
    request.setRequestHeader("x-csrf-token", csrf());
    request.setRequestHeader("content-type", "application/octet-stream");
    request.upload.onprogress = ({ loaded, total }) => (bar.value = total ? loaded / total : 0);
    request.onloadend = () => {
      bar.remove();
      setText(text, request.status >= 200 && request.status < 300 ? t("{name}: uploaded, is being read.", { name: file.name }) : t("{name}: not imported. {why}", { name: file.name, why: told(request) }));
      if (request.status < 200 || request.status >= 300) text.className = "bad-text";
      done();
    };
    request.send(file);
  }));
}

function told(request: XMLHttpRequest): string {
  try {
    return (JSON.parse(request.responseText) as { error: { text: string } }).error.text;
  } catch {
    return request.status ? t("The server answered {status}.", { status: request.status }) : t("The connection broke. Upload it again: what was read already is not added twice.");
  }
}

async function list(root: HTMLElement): Promise<void> {
  try {
    const imports = await getJson<Import[]>("/api/v1/import");
    const now = JSON.stringify(imports);
    if (root.dataset["told"] === now) return;
    root.dataset["told"] = now;
    if (!imports.length) {
      root.replaceChildren(make("p", { class: "dim" }, t("None.")));
      return;
    }
    await withWords(...imports.flatMap(({ problems }) => problems.map(({ says }) => says)));
    const head = make("tr");
    for (const name of [t("File"), t("Who"), t("When"), t("State"), t("Packets"), t("New"), t("Said")]) head.append(make("th", { scope: "col" }, name));
    const rows = imports.map((one) => {
      const damaged = one.damaged_bytes ? [tn(one.damaged_bytes, "{n} byte is not a packet", "{n} bytes are not packets")] : [];
      const cells = [one.name, one.person, utc(one.since_us), IMPORT_STATES[one.state], String(one.packets), String(one.added), [...one.problems.map(worded), ...damaged].join("; ")];
      const cancel = one.state === "running" ? [cancelButton(one)] : [];
      return make("tr", { "data-import": one.state }, ...cells.map((text, index) => make("td", index === 2 || index === 4 || index === 5 ? { class: "num" } : {}, text, ...(index === 3 ? cancel : []))));
    });
    root.replaceChildren(make("div", { class: "wide", tabindex: "0", role: "region", "aria-label": t("Imports") }, make("table", {}, make("thead", {}, head), make("tbody", {}, ...rows))));
  } catch (error) {
    delete root.dataset["told"];
    root.replaceChildren(make("p", { class: "bad-text" }, reason(error)));
  }
}

/** Ends an import; what was read stays. */
function cancelButton({ id, name }: Import): HTMLElement {
  const button = make("button", { type: "button", "aria-label": t("Cancel the import of {name}", { name }) }, t("Cancel"));
  button.addEventListener("click", () => {
    button.setAttribute("disabled", "");
    postJson<Import>(`/api/v1/import/${id}/cancel`, CANCEL_MS).catch((error: unknown) => {
      button.removeAttribute("disabled");
      button.title = reason(error);
    });
  });
  return button;
}

/** Everything that said where it was, with the way to the page on which it is replayed. */
async function watchable(root: HTMLElement): Promise<void> {
  try {
    const series = (await getJson<Recorded[]>("/api/v1/recorded")).filter((one) => one.abbrev === "EstimatedState");
    const told = series.map((one) => `${one.system} ${one.first_us} ${one.last_us}`).join();
    if (root.dataset["told"] === told) return;
    root.dataset["told"] = told;
    root.replaceChildren(
      ...series.map(({ system, first_us, last_us }) => {
        const address = hexAddress(system);
        return make("li", {}, make("a", { href: `/vessels/${system}` }, address), ` ${t("{from} to {to}", { from: utc(first_us), to: utc(last_us) })}`);
      }),
      ...(series.length ? [] : [make("li", { class: "dim" }, t("None yet."))]),
    );
  } catch {
    // The list of imports says that the server is not reached.
  }
}
