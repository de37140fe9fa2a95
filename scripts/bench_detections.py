"""What a season of detections takes; see bench-detections, which runs this. Standard library only."""

import csv
import hashlib
import json
import os
import random
import signal
import socket
import struct
import subprocess
import sys
import time
import urllib.error
import urllib.request

SERVER, FOLDER, COUNT = sys.argv[1], sys.argv[2], int(sys.argv[3])
# 2026-06-01 00:00 UTC, and a detection each ten seconds: a million are 116 days.
START_S, EVERY_S = 1_780_272_000, 10
VESSELS, TAGS = (0x0814, 0x0815, 0x0816), 200
TBR_FISH_TAG = 2007
QUIET_S = 1.0


def crc_table():
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = byte >> 1 ^ 0xA001 if byte & 1 else byte >> 1
        table.append(byte)
    return table


def write_log(path):
    """A log of TBRFishTag messages (IMC packets: header of 20 bytes, payload, CRC-16-IBM)."""
    table, chance = crc_table(), random.Random(7)
    header, payload = struct.Struct("<HHHdHBHB"), struct.Struct("<IIHBIHBBHdd")
    with open(path, "wb") as log:
        for at in range(COUNT):
            time_s = START_S + at * EVERY_S
            vessel = VESSELS[at % len(VESSELS)]
            body = payload.pack(
                1_000 + vessel % 16, time_s - 1, chance.randrange(1_000), 6, 1_000 + chance.randrange(TAGS), chance.randrange(256),
                chance.randrange(6, 60), 69, at % 65_536, 1.107 + chance.random() * 1e-3, 0.181 + chance.random() * 1e-3,
            )
            packet = header.pack(0xFE54, TBR_FISH_TAG, len(body), time_s, vessel, 9, 0xFFFF, 255) + body
            crc = 0
            for byte in packet:
                crc = crc >> 8 ^ table[(crc ^ byte) & 255]
            log.write(packet + struct.pack("<H", crc))


def told(what, took_s, more=""):
    print(f"{what}: {took_s * 1e3:.0f} ms{more and ', ' + more}", flush=True)


def run(*arguments, **more):
    done = subprocess.run([SERVER, *arguments], capture_output=True, text=True, **more)
    if done.returncode != 0:
        sys.exit(f"{' '.join(arguments)} failed: {done.stdout}{done.stderr}")
    return done.stdout


def imported(data, log):
    begun = time.monotonic()
    run("import", "--data", data, log)
    return time.monotonic() - begun


class Served:
    """A server on a data folder, and a script's access to it."""

    def __init__(self, data):
        run("user", "add", "bench", "--role", "admin", "--password-stdin", "--data", data, input="torsk i motbakke 41 seihale\n")
        self.token = run("token", "create", "--person", "bench", "--role", "researcher", "--data", data).split()[-1]
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.url = f"http://127.0.0.1:{port}"
        self.log = open(os.path.join(FOLDER, "server.log"), "wb")
        self.process = subprocess.Popen(
            [SERVER, "serve", "--listen", f"127.0.0.1:{port}", "--set", "imc.active=false", "--data", data],
            stdout=subprocess.DEVNULL, stderr=self.log,
        )
        while True:
            try:
                urllib.request.urlopen(self.url + "/healthz", timeout=5).read()
                break
            except (urllib.error.URLError, ConnectionError):
                if self.process.poll() is not None:
                    sys.exit(open(self.log.name).read())
                time.sleep(0.01)
        time.sleep(QUIET_S)
        self.rest_mib = self.memory_mib("VmRSS:")

    def end(self):
        self.process.send_signal(signal.SIGTERM)
        self.process.wait(60)

    def memory_mib(self, line):
        with open(f"/proc/{self.process.pid}/status") as status:
            return int(next(one for one in status if one.startswith(line)).split()[1]) / 1024

    def open(self, path):
        request = urllib.request.Request(self.url + path, headers={"Authorization": f"Bearer {self.token}"})
        try:
            return urllib.request.urlopen(request, timeout=1_800)
        except urllib.error.HTTPError as error:
            sys.exit(f"{path}: {error.code} {error.read()[:400].decode()}")

    def json(self, path):
        with self.open(path) as answer:
            return json.load(answer)

    def measured(self, what, path, into=None, is_whole=True):
        """Asks for a path; says how long it took, how much came, and how much memory it took over rest; of all detections how many a second."""
        # The greatest use of memory is counted from here on (proc(5), clear_refs).
        with open(f"/proc/{self.process.pid}/clear_refs", "w") as refs:
            refs.write("5")
        begun, size, out = time.monotonic(), 0, open(into, "wb") if into else None
        with self.open(path) as answer:
            while chunk := answer.read(1 << 20):
                size += len(chunk)
                if out:
                    out.write(chunk)
        if out:
            out.close()
        took_s = time.monotonic() - begun
        over_mib = self.memory_mib("VmHWM:") - self.rest_mib
        rate = f"{COUNT / took_s:,.0f} detections/s, " if is_whole else ""
        told(what, took_s, f"{size / 1e6:.1f} MB, {rate}{over_mib:.0f} MiB over rest at most")


def rows_of(path):
    """How many rows a table has, and a hash of all but when they came ashore: that differs between two servers."""
    digest, rows = hashlib.sha256(), 0
    with open(path, newline="", encoding="utf-8") as table:
        lines = csv.reader(table)
        names = next(lines)
        received = names.index("received_utc")
        for line in lines:
            if line[0].startswith("#ERROR"):
                sys.exit(f"{path} was cut: {line}")
            digest.update("\x1f".join(cell for at, cell in enumerate(line) if at != received).encode() + b"\n")
            rows += 1
    return rows, digest.hexdigest()


def first_picture(served):
    begun = time.monotonic()
    found = served.json("/api/v1/detections/summary")
    told("the explorer's first picture", time.monotonic() - begun, f"{found['detections']:,} detections in it")
    while found["read_from_us"] is not None:
        found = served.json("/api/v1/detections/summary")
    told("until it has all that it holds", time.monotonic() - begun, f"{found['detections']:,} detections")
    begun = time.monotonic()
    served.json("/api/v1/detections/summary")
    told("the picture once more", time.monotonic() - begun, f"{served.memory_mib('VmRSS:') - served.rest_mib:.0f} MiB over rest")


def main():
    log, data, other = (os.path.join(FOLDER, name) for name in ("season.lsf", "data", "other"))
    write_log(log)
    took_s = imported(data, log)
    told(f"{COUNT:,} detections of {len(VESSELS)} vessels imported", took_s, f"{COUNT / took_s:,.0f} detections/s")
    served = Served(data)
    print(f"memory at rest: {served.rest_mib:.0f} MiB", flush=True)
    span = f"from={START_S * 1000}&to={(START_S + COUNT * EVERY_S) * 1000}"
    table, again, exported = (os.path.join(FOLDER, name) for name in ("table.csv", "again.csv", "export.lsf"))
    try:
        first_picture(served)
        served.measured("CSV of all columns", "/api/v1/detections.csv", table)
        served.measured("Parquet", "/api/v1/detections.csv?format=parquet")
        served.measured("a page of rows for Grafana", f"/api/v1/table/detections?{span}", is_whole=False)
        served.measured("signal to noise ratio, 1000 points of each vessel", f"/api/v1/table?{span}&series=TBRFishTag.SNR", is_whole=False)
        served.measured("the log", "/api/v1/export.lsf", exported)
    finally:
        served.end()
    told("that log imported elsewhere", imported(other, exported))
    served = Served(other)
    try:
        served.measured("its CSV", "/api/v1/detections.csv", again)
    finally:
        served.end()
    one, two = rows_of(table), rows_of(again)
    if one != two or one[0] != COUNT:
        sys.exit(f"NOT equal: {COUNT:,} were written, {one} and {two} came back")
    print(f"equal: {one[0]:,} rows came back as they were, but for when they came ashore", flush=True)


main()
