"""What the programs take with the charts of a coast; see bench-coast, which runs this. Standard library only."""

import json
import math
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request

SERVER, FOLDER = sys.argv[1:3]
CHARTS = os.path.join(FOLDER, "chart.gpkg")


def harbour(block):
    """A place in the harbour of a block, as shore/benches/coast.rs lays them out (degrees)."""
    row, column = divmod(block, 40)
    return 63.446 - 0.65 * row, 10.345 + 0.37 * column - 20.0


def told(what, took_s, peak_kib=None, goal=""):
    memory = "" if peak_kib is None else f", {peak_kib / 1024:.0f} MiB at most"
    print(f"{what}: {took_s * 1e3:.1f} ms{memory}{goal and f' (goal {goal})'}", flush=True)


def measured(what, arguments, goal=""):
    """Runs a command and tells how long it took and how much memory, by way of a process whose only child it is."""
    script = (
        "import resource,subprocess,sys,time\n"
        "t=time.monotonic()\n"
        "r=subprocess.run(sys.argv[1:],stdout=subprocess.PIPE,stderr=subprocess.STDOUT)\n"
        "print(r.returncode,time.monotonic()-t,resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)\n"
        "print(r.stdout.decode()[:300])"
    )
    said = subprocess.run([sys.executable, "-c", script, SERVER, *arguments], capture_output=True, text=True)
    code, took_s, peak_kib = said.stdout.split("\n")[0].split()
    if code != "0":
        print(f"{what}: failed: {said.stdout[:400].strip()}", flush=True)
    else:
        told(what, float(took_s), int(peak_kib), goal)


class Served:
    """A server with the set, and a script's access to it."""

    def __init__(self, data):
        self.data = data
        common = ["--data", data, "--set", f"charts.set={CHARTS}"]
        subprocess.run(
            [SERVER, "user", "add", "bench", "--role", "admin", "--password-stdin", *common],
            input=b"torsk i motbakke 41 seihale", check=True, capture_output=True,
        )
        made = subprocess.run(
            [SERVER, "token", "create", "--person", "bench", "--role", "viewer", *common],
            check=True, capture_output=True, text=True,
        )
        self.token = made.stdout.split()[-1] if "lutra" not in made.stdout else next(
            word for word in made.stdout.split() if word.startswith("lutra")
        )
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.url = f"http://127.0.0.1:{port}"
        self.begun = time.monotonic()
        self.process = subprocess.Popen(
            [SERVER, "serve", "--listen", f"127.0.0.1:{port}", *common],
            stdout=subprocess.DEVNULL, stderr=open(os.path.join(data, "server.log"), "wb"),
        )
        while True:
            try:
                urllib.request.urlopen(self.url + "/healthz", timeout=5).read()
                break
            except (urllib.error.URLError, ConnectionError):
                if self.process.poll() is not None:
                    sys.exit(open(os.path.join(data, "server.log")).read())
                time.sleep(0.002)
        told("a server's start to its first answer", time.monotonic() - self.begun)

    def ask(self, path, body=None):
        """An answer's bytes, or what it says that went wrong."""
        request = urllib.request.Request(
            self.url + path, None if body is None else json.dumps(body).encode(),
            {"Authorization": f"Bearer {self.token}", "Content-Type": "application/json"},
        )
        begun = time.monotonic()
        try:
            with urllib.request.urlopen(request, timeout=900) as answer:
                read = answer.read()
        except urllib.error.HTTPError as error:
            read = error.read()
        return time.monotonic() - begun, read

    def memory_mib(self, line):
        with open(f"/proc/{self.process.pid}/status") as status:
            return int(next(one for one in status if one.startswith(line)).split()[1]) / 1024

    def memory(self, when):
        now, peak = self.memory_mib("VmRSS:"), self.memory_mib("VmHWM:")
        print(f"memory {when}: {now:.0f} MiB, at most {peak:.0f} MiB (goal 300 MiB)", flush=True)

    def end(self):
        self.process.send_signal(signal.SIGTERM)
        self.process.wait(60)


def tile_of(zoom, at):
    lat, lon = at
    wide = 2**zoom
    y = (1 - math.asinh(math.tan(math.radians(lat))) / math.pi) / 2
    return f"/api/v1/chart/tiles/{zoom}/{int((lon + 180) / 360 * wide)}/{int(y * wide)}"


def distance_km(one, other):
    (lat_1, lon_1), (lat_2, lon_2) = one, other
    north = (lat_2 - lat_1) * 111.2
    east = (lon_2 - lon_1) * 111.32 * math.cos(math.radians((lat_1 + lat_2) / 2))
    return math.hypot(north, east)


def route(served, what, one, other, clearance_m, depth_m, goal=""):
    """A route for the first time, and the quickest of five more."""
    body = {"points": [list(one), list(other)], "least_depth_m": depth_m, "clearance_m": clearance_m}
    first_s, read = served.ask("/api/v1/chart/route", body)
    answer = json.loads(read)
    again_s = min(served.ask("/api/v1/chart/route", body)[0] for _ in range(5))
    way = answer.get("route")
    length = f"{way['length_m'] / 1e3:.1f} km" if way else f"no route: {json.dumps(answer)[:160]}"
    print(
        f"{what}, {distance_km(one, other):.0f} km straight, {depth_m} m deep, {clearance_m} m clear: "
        f"first {first_s * 1e3:.0f} ms, then {again_s * 1e3:.1f} ms{goal and f' (goal {goal})'}; {length}",
        flush=True,
    )


def first_look(served):
    """All that a browser asks of the chart when a page with a map is opened."""
    while json.loads(served.ask("/api/v1/chart")[1]).get("cells") in (None, []):
        time.sleep(0.01)
    told("a server's start to the set in force", time.monotonic() - served.begun)
    at = harbour(0)
    told("first look: the first tile of a harbour", served.ask(tile_of(14, at))[0], goal="100 ms")
    told("first look: the first depth", served.ask(f"/api/v1/chart/at?lat={at[0]}&lon={at[1]}")[0], goal="100 ms")
    told("the list of all charts", served.ask("/api/v1/chart")[0])
    served.memory("after the first look")


def harbours(served):
    took = []
    for block in range(40):
        at = harbour(block)
        took.append(served.ask(f"/api/v1/chart/at?lat={at[0]}&lon={at[1]}&radius_m=500")[0])
        took += [served.ask(tile_of(zoom, at))[0] for zoom in range(10, 17)]
    told("forty harbours, depths and tiles of zoom 10 to 16, the slowest of 320", max(took))
    served.memory("after forty harbours")


def one_cell(served):
    """A cell is brought in by the command while the server runs, until the server goes by it."""
    small = os.path.join(FOLDER, "small")
    name = os.path.splitext(os.listdir(small)[0])[0]
    charts = len(json.loads(served.ask("/api/v1/chart")[1])["cells"])
    begun = time.monotonic()
    measured("one more cell of 14 kB", ["chart", "import", "--db", CHARTS, small], "1 s")
    while len(json.loads(served.ask("/api/v1/chart")[1])["cells"]) == charts:
        time.sleep(0.02)
        if time.monotonic() - begun > 60:
            print("the server does not take the cell", flush=True)
            break
    told("until the server goes by it (it looks every 2 s)", time.monotonic() - begun)
    at = harbour(0)
    told("the first depth after it", served.ask(f"/api/v1/chart/at?lat={at[0]}&lon={at[1]}")[0])
    measured("the same taken out", ["chart", "remove", "--db", CHARTS, name])


def main():
    # The steps before leave it in.
    small = os.path.splitext(os.listdir(os.path.join(FOLDER, "small"))[0])[0]
    subprocess.run([SERVER, "chart", "remove", "--db", CHARTS, small], capture_output=True)
    for _ in range(2):
        at = ",".join(map(str, harbour(0)))
        measured("chart depth", ["chart", "depth", "--db", CHARTS, "--at", at, "--needs", "0"], "50 ms, 50 MiB")
    data = tempfile.mkdtemp(prefix="lutra-coast-data.")
    served = Served(data)
    try:
        first_look(served)
        one_cell(served)
        harbours(served)
        lat, lon = harbour(0)
        near = [(lat + 0.004, lon + 0.01), (lat - 0.004, lon - 0.01)]
        route(served, "a route within a harbour", near[0], near[1], 25, 2)
        served.memory("after it")
        route(served, "a route to the next harbour", harbour(0), harbour(1), 25, 2)
        route(served, "a route along five blocks", harbour(0), harbour(5), 25, 2)
        served.memory("after them")
        # Over more chart than a region may hold: tile by tile. The blocks are not joined by water.
        route(served, "a long route along the coast", harbour(0), harbour(28), 25, 2, "100 ms")
        served.memory("after it")
    finally:
        served.end()
        shutil.rmtree(data, ignore_errors=True)


main()
