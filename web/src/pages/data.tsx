// Taking data away: what was recorded on which day, and files of it, with their size before they are fetched.

import { computed, effect, signal } from "@preact/signals";
import { render } from "preact";
import type { ExportSize, Import, Recorded, RecordedDay } from "../api/types.gen";
import { resource } from "../api/resource";
import { Recorded as RecordedDays } from "../components/recorded";
import { Spans, TimeSpan } from "../components/timespan";
import { bytesText, fieldOf, fileOf, type Kind, KINDS, logBytes, picked, sizeOf, type Wanted, wrongOf } from "../state/takeout";
import { createChrome } from "../ui/chrome";
import { utc } from "../ui/format";

/** After the last change of the form the size is asked for, ms. */
const REST_MS = 350;

export function startData(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["names"] ?? "{}") as Record<string, string>;
  const [may, admin] = [root.dataset["researcher"] !== undefined, root.dataset["admin"] !== undefined];
  const [days, recorded, imports, size] = [resource<RecordedDay[]>(), resource<Recorded[]>(), resource<Import[]>(), resource<ExportSize>()];
  const [kind, message, vessel] = [signal<Kind>("positions"), signal("EstimatedState"), signal("")];
  const [from, to, every_s] = [signal(""), signal(""), signal("")];
  const [angles, gzip] = [signal<"deg" | "rad">("deg"), signal(false)];
  const wanted = computed<Wanted>(() => ({ kind: kind.value, message: message.value, vessel: vessel.value, from: from.value, to: to.value, angles: angles.value, every_s: every_s.value, gzip: gzip.value }));
  const wrong = computed(() => wrongOf(wanted.value) ?? (sizeOf(wanted.value) && size.trouble.value ? fieldOf(size.trouble.value) : undefined));
  const wrongAt = (field: string): string => (wrong.value?.field === field ? wrong.value.text : "");
  const called = ({ system, name }: Pick<RecordedDay, "system" | "name">): string => names[String(system)] ?? name;
  const vessels = computed(() => {
    const all = new Map<number, string>(Object.entries(names).map(([address, name]) => [Number(address), name]));
    for (const day of days.value.value ?? []) if (!all.has(day.system)) all.set(day.system, called(day));
    return [...all].sort(([, one], [, other]) => one.localeCompare(other));
  });
  const messages = computed(() => [...new Set((recorded.value.value ?? []).filter((one) => !vessel.value || String(one.system) === vessel.value).map(({ abbrev }) => abbrev))].sort());
  const choose = (day: RecordedDay): void => {
    // Whole seconds around it, as the date pickers have them.
    [vessel.value, from.value, to.value] = [String(day.system), picked(day.first_us), picked(day.last_us + 1_000_000)];
    document.getElementById("take-out")?.scrollIntoView({ block: "start" });
    document.getElementById("download")?.focus({ preventScroll: true });
  };
  let timer = 0;
  effect(() => {
    const path = may && !wrongOf(wanted.value) ? sizeOf(wanted.value) : "";
    window.clearTimeout(timer);
    timer = window.setTimeout(() => void (path && size.ask(path)), REST_MS);
  });

  const Size = () => {
    if (wrong.value) return <p role="status">{wrong.value.field ? "" : <span class="bad-text">{wrong.value.text}</span>}</p>;
    if (kind.value === "log") return <p role="status">At most {bytesText(logBytes(days.value.value ?? [], wanted.value))}.</p>;
    if (kind.value === "detections") return <p role="status"><a href="/detections">See them first on the page Detections.</a></p>;
    if (size.busy.value || !size.value.value) return <p role="status">Looking how large it will be …</p>;
    const { rows, bytes } = size.value.value;
    return <p role="status">{rows === 0 ? "No rows in this time: the file will have its header only." : `${rows.toLocaleString("en")} rows, about ${bytesText(bytes)}${gzip.value ? " before it is packed" : ""}.`}</p>;
  };
  const Form = () => (
    <form class="take-out" onSubmit={(event) => event.preventDefault()} aria-label="Files">
      <fieldset class="kinds">
        <legend>What</legend>
        {KINDS.map(([name, title, about]) => (
          <label key={name} class="kind" data-chosen={kind.value === name ? "" : undefined}>
            <input type="radio" name="kind" value={name} checked={kind.value === name} onChange={() => (kind.value = name)} />
            <span><strong>{title}</strong><span class="about">{about}</span></span>
          </label>
        ))}
      </fieldset>
      <div class="filters">
        {kind.value === "messages" && (
          <div class="field">
            <label for="message">Message</label>
            <input id="message" list="messages" value={message.value} autocomplete="off" spellcheck={false} aria-invalid={wrongAt("message") !== ""} aria-describedby="message-wrong" onInput={(event) => (message.value = event.currentTarget.value)} />
            <datalist id="messages">{messages.value.map((name) => <option key={name} value={name} />)}</datalist>
            <p id="message-wrong" class="wrong" role="alert">{wrongAt("message")}</p>
          </div>
        )}
        <div class="field">
          <label for="of-vessel">Vessel</label>
          <select id="of-vessel" value={vessel.value} aria-describedby="vessel-wrong" onChange={(event) => (vessel.value = event.currentTarget.value)}>
            <option value="">All vessels</option>
            {vessels.value.map(([address, name]) => <option key={address} value={String(address)}>{name}</option>)}
          </select>
          <p id="vessel-wrong" class="wrong" role="alert">{wrongAt("vessel")}</p>
        </div>
        <TimeSpan from={from} to={to} fromWrong={wrongAt("from")} toWrong={wrongAt("to")} />
        {(kind.value === "positions" || kind.value === "messages") && (
          <>
            <div class="field">
              <label for="angles">Angles</label>
              <select id="angles" value={angles.value} onChange={(event) => (angles.value = event.currentTarget.value as "deg" | "rad")}><option value="deg">degrees</option><option value="rad">radians</option></select>
            </div>
            <div class="field">
              <label for="every">Seconds from row to row</label>
              <input id="every" inputMode="decimal" value={every_s.value} placeholder={kind.value === "positions" ? "1" : "every row"} aria-invalid={wrongAt("every_s") !== ""} aria-describedby="every-wrong" onInput={(event) => (every_s.value = event.currentTarget.value.trim().replace(",", "."))} />
              <p id="every-wrong" class="wrong" role="alert">{wrongAt("every_s")}</p>
            </div>
          </>
        )}
      </div>
      <Spans from={from} to={to} />
      <label class="inline"><input type="checkbox" checked={gzip.value} onChange={(event) => (gzip.value = event.currentTarget.checked)} />Packed by gzip</label>
      <div class="fetch">{wrong.value ? <button type="button" id="download" class="main" disabled>Download</button> : <a id="download" class="button main" href={fileOf(wanted.value)} download>Download</a>}<Size /></div>
    </form>
  );
  const Imports = () => (
    <section>
      <h2>Brought in</h2>
      {imports.value.value?.length ? (
        <ul class="imports">{imports.value.value.map((one) => <li key={one.id}><strong>{one.name}</strong> by {one.person}, {utc(one.since_us)}: {one.packets.toLocaleString("en")} packets, {one.state}</li>)}</ul>
      ) : <p>{imports.trouble.value || "No log was brought in since the server started."}</p>}
      <p><a href="/admin/import">Bring a log in</a></p>
    </section>
  );
  const Page = () => (
    <>
      {may ? <section id="take-out"><h2>Files</h2><Form /></section> : <p class="note">Whoever takes data away has the role researcher; an admin gives it.</p>}
      <section>
        <h2>Recorded</h2>
        {days.trouble.value && <p class="bad-text" role="alert">{days.trouble.value} <button type="button" onClick={() => void days.ask("/api/v1/recorded/days")}>Try again</button></p>}
        {days.value.value?.length === 0 && <p>Nothing is recorded yet. What a vessel sends is recorded by itself, from its first packet.</p>}
        {days.value.value?.length ? <RecordedDays days={days.value.value} called={called} may={may} choose={choose} /> : null}
      </section>
      {admin && <Imports />}
    </>
  );
  root.replaceChildren();
  render(<Page />, root);
  createChrome({ messages: ["VehicleState"], events: false, every_ms: 500 }, {});
  void days.ask("/api/v1/recorded/days");
  void recorded.ask("/api/v1/recorded");
  if (admin) void imports.ask("/api/v1/import");
}
