// The load and the table of scripts/soak: node --experimental-websocket soak.mjs SERVER FOLDER SECONDS VESSELS SERIES SOCKETS EVERY_S.
// Vessels speak IMC by the IMCProxy transport, each over a connection of its own, and their packets are spread over the time.
// Sockets are as pages have them: most look at all series of one vessel, some at the positions of all, in the compact form. A
// value's age on arrival is measured by one clock, as all is on this computer.

import { spawn } from "node:child_process";
import { once } from "node:events";
import { readdir, readFile, stat } from "node:fs/promises";
import { join } from "node:path";
import { createInterface } from "node:readline";

const [program, folder, ...numbers] = process.argv.slice(2);
const [SECONDS, VESSELS, SERIES, SOCKETS, EVERY_S] = numbers.map(Number);
const data = join(folder, "data");
/** The first vessel's address; the others follow. */
const FIRST = 0x0900;
const TICK_MS = 20;
/** What is flat is judged after this, and lines of the table are as long, s; in a short run each is a sixth of it. */
const SETTLED_S = Math.min(600, SECONDS / 6);
const LINE_S = Math.min(300, SECONDS / 12);
/** So much may the second half after that have more than the first: of memory as share, of file descriptors as number, of p99 as
 * share, with what is noise on any computer. */
const [MORE_MEMORY, MORE_MB, MORE_FILES, MORE_LATE, MORE_MS] = [0.05, 8, 8, 0.5, 20];

// IMC: header, payload, CRC-16 (x^16 + x^15 + x^2 + 1, reflected).
const CRC = Uint16Array.from({ length: 256 }, (_, byte) => {
  let crc = byte;
  for (let bit = 0; bit < 8; bit++) crc = crc & 1 ? (crc >> 1) ^ 0xa001 : crc >> 1;
  return crc;
});

function packet(id, source, entity, payload) {
  const bytes = Buffer.alloc(20 + payload.length + 2);
  bytes.writeUInt16LE(0xfe54, 0);
  bytes.writeUInt16LE(id, 2);
  bytes.writeUInt16LE(payload.length, 4);
  bytes.writeUInt16LE(source, 14);
  bytes[16] = entity;
  bytes.writeUInt16LE(0xffff, 17);
  bytes[19] = 0xff;
  payload.copy(bytes, 20);
  return bytes;
}

function seal(bytes, seconds) {
  bytes.writeDoubleLE(seconds, 6);
  let crc = 0;
  const end = bytes.length - 2;
  for (let at = 0; at < end; at++) crc = (crc >> 8) ^ CRC[(crc ^ bytes[at]) & 0xff];
  bytes.writeUInt16LE(crc, end);
}

/** A vessel's series: its state of 20 fields, and measurements of many parts: Temperature (263) and Voltage (251), of a float each. */
function seriesOf(vessel) {
  const state = Buffer.alloc(88);
  state.writeDoubleLE(1.1072 + vessel * 1e-5, 0);
  state.writeDoubleLE(0.1815, 8);
  const all = [packet(350, FIRST + vessel, 1, state)];
  for (let at = 1; at < SERIES; at++) {
    const [id, entity] = [at % 2 ? 263 : 251, 2 + ((at - 1) >> 1)];
    all.push(packet(id, FIRST + vessel, entity, Buffer.alloc(4)));
  }
  return all;
}

async function run(args, input = "") {
  const child = spawn(program, [...args, "--data", data], { stdio: ["pipe", "pipe", "inherit"] });
  let said = "";
  child.stdout.on("data", (part) => (said += part));
  child.stdin.end(input);
  const [code] = await once(child, "close");
  if (code !== 0) throw new Error(`lutra-server ${args.join(" ")} failed`);
  return said.trim();
}

async function serve() {
  const set = ["imc.active=false", "transports.imcproxy.listen=127.0.0.1:0", `transports.imcproxy.max_peers=${VESSELS + 8}`, "http.max_connections=1000", "log.level=warn"];
  const args = ["serve", "--listen", "127.0.0.1:0", ...set.flatMap((one) => ["--set", one]), "--data", data];
  const server = spawn(program, args, { stdio: ["ignore", "pipe", "inherit"] });
  const told = {};
  for await (const line of createInterface({ input: server.stdout })) {
    told.web ??= /^listening http:\/\/(\S+)/.exec(line)?.[1];
    told.proxy ??= /^imcproxy (\S+)/.exec(line)?.[1];
    if (told.web && told.proxy) return { server, ...told };
  }
  throw new Error("the server ended before it listened");
}

const heard = { ages: [], values: 0, frames: 0, skipped: 0 };

/** A socket as a page has it. */
async function look(web, token, number) {
  const socket = new WebSocket(`ws://${web}/api/live`, { headers: { authorization: `Bearer ${token}` } });
  socket.binaryType = "arraybuffer";
  const stream = new DecompressionStream("deflate-raw");
  const writer = stream.writable.getWriter();
  const came = [];
  socket.onmessage = ({ data: message }) => {
    if (typeof message === "string") return;
    came.push(performance.timeOrigin + performance.now());
    writer.write(new Uint8Array(message));
  };
  const fleet = number % 5 === 4;
  const wanted = fleet ? { messages: ["EstimatedState", "VehicleState"] } : { systems: [FIRST + (number % VESSELS)], of_others: ["VehicleState"] };
  socket.onopen = () => socket.send(JSON.stringify({ subscribe: { ...wanted, compact: true } }));
  let ended = false;
  socket.onclose = () => {
    if (!over && !ended) console.error(`socket ${number} was closed by the server`);
    ended = true;
  };
  void read(stream.readable.getReader(), came);
  await new Promise((done, fail) => ((socket.onerror = () => fail(new Error("a live socket failed"))), socket.addEventListener("open", done)));
  return socket;
}

async function read(reader, came) {
  const decoder = new TextDecoder();
  let text = "";
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    const [end, ...next] = decoder.decode(part.value, { stream: true }).split("\n");
    text += end;
    for (const begun of next) {
      take(JSON.parse(text), came.shift());
      text = begun;
    }
  }
}

function take(frame, now) {
  heard.frames += 1;
  heard.skipped += frame.skipped;
  // The first has what was there before.
  if (frame.snapshot) return;
  heard.values += frame.samples.length;
  // One of ten is enough for a percentile.
  frame.samples.forEach(({ time_us }, at) => at % 10 === 0 && heard.ages.push(now - time_us / 1e3));
}

async function diskBytes(path) {
  let bytes = 0;
  for (const entry of await readdir(path, { withFileTypes: true })) {
    const inner = join(path, entry.name);
    // A file of a moment may be gone by now.
    bytes += entry.isDirectory() ? await diskBytes(inner) : ((await stat(inner).catch(() => undefined))?.blocks ?? 0) * 512;
  }
  return bytes;
}

async function state(pid) {
  const status = await readFile(`/proc/${pid}/status`, "utf8");
  const ticks = (await readFile(`/proc/${pid}/stat`, "utf8")).split(") ")[1].split(" ");
  return {
    mb: Number(/^VmRSS:\s+(\d+)/m.exec(status)[1]) / 1024,
    files: (await readdir(`/proc/${pid}/fd`)).length,
    disk: await diskBytes(data),
    cpuS: (Number(ticks[11]) + Number(ticks[12])) / 100,
  };
}

function percentile(sorted, share) {
  return sorted[Math.min(sorted.length - 1, Math.floor(sorted.length * share))] ?? NaN;
}

/** One line of the table: what happened since the last, and how the server is. */
async function line(pid, before, beganMs, lastMs, sent) {
  const [now, nowMs] = [await state(pid), performance.now()];
  const [seconds, ages] = [(nowMs - lastMs) / 1e3, heard.ages.sort((a, b) => a - b)];
  const row = {
    atS: (nowMs - beganMs) / 1e3,
    mb: now.mb,
    files: now.files,
    perHour: (now.disk - before.disk) / 1e6 / VESSELS / (seconds / 3_600),
    cpu: (100 * (now.cpuS - before.cpuS)) / seconds,
    packets: sent / seconds,
    values: heard.values / seconds,
    p50: percentile(ages, 0.5),
    p99: percentile(ages, 0.99),
    most: ages.at(-1) ?? NaN,
    skipped: heard.skipped,
  };
  Object.assign(heard, { ages: [], values: 0, frames: 0, skipped: 0 });
  const cells = [(row.atS / 60).toFixed(1), row.mb.toFixed(1), row.files, row.perHour.toFixed(2), row.cpu.toFixed(0), row.packets.toFixed(0), row.values.toFixed(0)];
  console.log(`| ${[...cells, row.p50.toFixed(0), row.p99.toFixed(0), row.most.toFixed(0), row.skipped].join(" | ")} |`);
  return { row, now };
}

/** Whether the second half after the beginning has no more than the first. */
function judge(rows) {
  const settled = rows.filter((row) => row.atS > SETTLED_S);
  const [first, second] = [settled.slice(0, settled.length >> 1), settled.slice(settled.length >> 1)];
  const mean = (part, of) => part.reduce((sum, row) => sum + row[of], 0) / part.length;
  const grows = [];
  const compare = (name, of, share, noise, unit) => {
    const [one, other] = [mean(first, of), mean(second, of)];
    console.log(`${name}: ${one.toFixed(1)} ${unit}, then ${other.toFixed(1)} ${unit}`);
    if (other > one * (1 + share) + noise) grows.push(name);
  };
  console.log(`\nthe two halves after ${(SETTLED_S / 60).toFixed(1)} min:`);
  compare("memory", "mb", MORE_MEMORY, MORE_MB, "MB");
  compare("file descriptors", "files", 0, MORE_FILES, "");
  compare("p99 of live values", "p99", MORE_LATE, MORE_MS, "ms");
  compare("disk per vessel-hour", "perHour", MORE_LATE, 1, "MB");
  console.log(grows.length ? `NOT FLAT: ${grows.join(", ")}` : `flat after ${(SETTLED_S / 60).toFixed(1)} min`);
  return grows.length === 0;
}

let over = false;
await run(["user", "add", "nils", "--role", "admin", "--password-stdin"], "seven small boats\n");
const token = await run(["token", "create", "--person", "nils", "--role", "admin"]);
const { server, web, proxy } = await serve();
try {
  server.once("exit", (code) => over || (console.error(`the server ended with ${code}`), process.exit(1)));
  const fleet = [];
  for (let vessel = 0; vessel < VESSELS; vessel++) {
    const socket = new WebSocket(proxy);
    socket.binaryType = "arraybuffer";
    await new Promise((done, fail) => ((socket.onopen = done), (socket.onerror = () => fail(new Error("a vessel is refused")))));
    socket.onclose = () => over || console.error(`vessel ${vessel} was disconnected by the server`);
    fleet.push({ socket, series: seriesOf(vessel) });
  }
  let [sent, at] = [0, 0];
  const all = VESSELS * SERIES;
  const beganMs = performance.now();
  const sail = setInterval(() => {
    // As many as are due by now, so that a late timer drops nothing.
    const due = Math.floor((((performance.now() - beganMs) / 1e3) * all) / EVERY_S);
    for (; at < due; at++) {
      // One series after the other, each of all vessels.
      const { socket, series } = fleet[at % VESSELS];
      const bytes = series[Math.floor(at / VESSELS) % SERIES];
      const seconds = (performance.timeOrigin + performance.now()) / 1e3;
      bytes.writeFloatLE(Math.sin(seconds / 60 + at) * 10, bytes.length - 6);
      seal(bytes, seconds);
      socket.send(bytes);
      sent += 1;
    }
  }, TICK_MS);
  const sockets = [];
  for (let number = 0; number < SOCKETS; number++) sockets.push(await look(web, token, number));

  console.log(`${VESSELS} vessels x ${SERIES} series, a value each ${EVERY_S} s, ${SOCKETS} live sockets, ${(SECONDS / 60).toFixed(1)} min`);
  console.log("| min | memory MB | files | disk MB per vessel-hour | cpu % | packets/s | live values/s | p50 ms | p99 ms | most ms | replaced |");
  console.log("|---|---|---|---|---|---|---|---|---|---|---|");
  const rows = [];
  let [before, lastMs] = [await state(server.pid), performance.now()];
  while ((performance.now() - beganMs) / 1e3 < SECONDS - 1) {
    await new Promise((done) => setTimeout(done, LINE_S * 1e3));
    const was = sent;
    sent = 0;
    const { row, now } = await line(server.pid, before, beganMs, lastMs, was);
    [before, lastMs] = [now, performance.now()];
    rows.push(row);
  }
  clearInterval(sail);
  over = true;
  for (const socket of [...sockets, ...fleet.map((one) => one.socket)]) socket.close();
  process.exitCode = judge(rows) ? 0 : 1;
} finally {
  over = true;
  server.kill("SIGTERM");
  await once(server, "exit");
}
process.exit();
