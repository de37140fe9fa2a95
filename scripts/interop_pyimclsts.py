"""A scripted mission: pyimclsts packs and unpacks every message, `lutra-agent run` sails.

Every step ends in `ok` or in what differed, the first failure ends the run with 1. A line `DUNE:` tells where
the vessel answers otherwise than a real DUNE does, without that being wrong. Nothing sleeps: each wait is for
a packet, with a deadline. Usage: interop_pyimclsts.py LUTRA_AGENT CONFIG
"""

import hashlib
import math
import select
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import traceback
from pathlib import Path

from pyimclsts import core, network

# `network` loads the module that `pyimclsts.extract` made of the IMC.xml in the working directory.
imc = sys.modules["pyimc_generated"].messages
# Its getters copy nested messages and fail at that (0.1.2.1, Python 3.11); here nobody changes what came.
sys.modules["pyimc_generated"]._base.base_message.__deepcopy__ = lambda message, _: message

VESSEL, CONSOLE, STRANGER = 0x2810, 0x4001, 0x4002
SYNC = b"\x54\xfe"
DEADLINE = 30.0
EARTH_M = 6_371_000.0
REQUEST, SUCCESS, FAILURE, IN_PROGRESS = range(4)
START, STOP = 0, 1
BLOCKED, READY, INITIALIZING, EXECUTING = range(4)
SERVICE, ERROR, MANEUVER = 0, 2, 3


class Differs(Exception):
    """The vessel did something else than is expected."""


def expect(good, what):
    if not good:
        raise Differs(what)


class Agent:
    """The program in a folder of its own, on ports of loopback that the system chose."""

    def __init__(self, program, config, folder):
        shutil.copy(config, folder / "otter.ini")
        self.stderr = open(folder / "stderr", "w+")
        self.process = subprocess.Popen(
            [program, "run", folder / "otter.ini", "--profile", "Simulation", "--data", folder, "--quiet",
             "--bind", "127.0.0.1", "--udp-port", "0", "--tcp-port", "0", "--announce-port", "0"],
            stdout=subprocess.PIPE, stderr=self.stderr, text=True)  # fmt: skip
        ready, _, _ = select.select([self.process.stdout], [], [], DEADLINE)
        line = self.process.stdout.readline() if ready else ""
        expect(line.startswith("listening "), f"the agent said {line!r} at its start")
        self.tcp = int(dict(word.split("=") for word in line.split()[1:])["tcp"])

    def terminate(self):
        self.process.send_signal(signal.SIGTERM)
        out, _ = self.process.communicate(timeout=DEADLINE)
        expect(self.process.returncode == 0, f"the agent ended with {self.process.returncode}")
        expect(out.startswith("motors stopped"), f"the agent said {out!r} at its end")
        return out.strip()

    def kill(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self.stderr.seek(0)
        return self.stderr.read()


class Console:
    """One stream of packets; what came is kept in the order of its arrival."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), DEADLINE)
        self.buffer = bytearray()
        self.seen = []  # (monotonic time, message)
        self.late = []  # arrival by our clock less the header's time
        self.mark = 0
        self.request_id = 0
        self.beat = 0.0
        self.types = set()

    def send(self, message, src=CONSOLE):
        self.socket.sendall(message.pack(is_big_endian=False, src=src, src_ent=255, dst=VESSEL, dst_ent=255))

    def begin(self):
        """From here on counts what a step waits for."""
        self.mark = len(self.seen)

    def unpack(self, packet):
        crc = int.from_bytes(packet[-2:], "little")
        expect(core.CRC16IMB(packet[:-2]) == crc, f"pyimclsts finds a wrong CRC: {packet.hex()}")
        try:
            message = network.unpack(packet)
        except Exception as error:
            raise Differs(f"pyimclsts cannot unpack {packet.hex()}: {error!r}") from error
        abbrev = type(message).__name__
        expect(abbrev != "Unknown", f"pyimclsts does not know {packet.hex()}")
        expect(message.pack(is_big_endian=False) == packet, f"pyimclsts packs {abbrev} otherwise: {packet.hex()}")
        self.types.add(abbrev)
        return message

    def receive(self, seconds):
        """Reads what comes within some seconds, at least once; keeps the contact alive."""
        now = time.monotonic()
        if now - self.beat > 0.8:
            self.beat = now
            self.send(imc.Heartbeat())
        if not select.select([self.socket], [], [], max(0.0, min(seconds, 0.2)))[0]:
            return
        data = self.socket.recv(65536)
        expect(data, "the agent hung up")
        self.buffer += data
        while len(self.buffer) >= 6:
            expect(self.buffer[:2] == SYNC, f"the stream is out of step: {bytes(self.buffer[:40]).hex()}")
            size = int.from_bytes(self.buffer[4:6], "little") + 22
            if len(self.buffer) < size:
                break
            self.seen.append((time.monotonic(), self.unpack(bytes(self.buffer[:size]))))
            self.late.append(time.time() - self.seen[-1][1]._header.timestamp)
            del self.buffer[:size]

    def since(self, kind=None):
        found = [message for _, message in self.seen[self.mark :]]
        return [message for message in found if kind is None or isinstance(message, kind)]

    def wait(self, what, kind, wanted=lambda message: True, within=DEADLINE, also=lambda: None, after=None):
        """The first message that is wanted, with its place in the order of arrival."""
        at = self.mark if after is None else after + 1
        until = time.monotonic() + within
        while True:
            while at < len(self.seen):
                message = self.seen[at][1]
                if isinstance(message, kind) and wanted(message):
                    return message, at
                at += 1
            left = until - time.monotonic()
            if left <= 0:
                raise Differs(f"{what}: not within {within} s; last {kind.__name__}: {self.last(kind)!r}")
            also()
            self.receive(left)

    def last(self, kind):
        return next((message for _, message in reversed(self.seen) if isinstance(message, kind)), None)

    def database(self, op, plan_id="", arg=None):
        """All replies to a request to the plan database, the last of which says yes or no."""
        self.request_id += 1
        number = self.request_id
        self.begin()
        self.send(imc.PlanDB(REQUEST, op, number, plan_id, arg, ""))
        ours = lambda reply: reply.request_id == number and reply.op == op and to_us(reply)
        self.wait("PlanDB", imc.PlanDB, lambda reply: ours(reply) and reply.type in (SUCCESS, FAILURE))
        return [reply for reply in self.since(imc.PlanDB) if ours(reply)]

    def ask(self, op, plan_id="", arg=None):
        self.request_id += 1
        self.begin()
        self.send(imc.PlanControl(REQUEST, op, self.request_id, plan_id, 0, arg, ""))
        return self.request_id

    def reply(self, number, kind, info=None, within=DEADLINE):
        """The vessel's reply to a request, with some text if one is given."""

        def ours(reply):
            return reply.request_id == number and reply.type != REQUEST and to_us(reply)

        def wanted(reply):
            if not ours(reply):
                return False
            other = FAILURE if kind == SUCCESS else SUCCESS
            early = kind == FAILURE  # a start that succeeded may fail later
            expect(early or reply.type != other, f"request {number} was answered {reply!r}")
            return reply.type == kind and (info is None or info in reply.info)

        return self.wait(f"reply {info!r} to request {number}", imc.PlanControl, wanted, within)

    def start(self, plan_id, arg=None):
        number = self.ask(START, plan_id, arg)
        self.reply(number, SUCCESS, "plan loaded")
        self.reply(number, SUCCESS, "executing maneuver")
        self.wait("executing", imc.PlanControlState, lambda s: s.state == EXECUTING and s.plan_id == plan_id)
        return number


def to_us(message):
    return message._header.src == VESSEL and message._header.dst == CONSOLE


def note(text):
    print(f"       DUNE: {text}", flush=True)


def payload(message):
    """What pyimclsts puts between header and CRC; as of a nested message, so that the header stays as it came."""
    return message.pack(is_big_endian=False, is_field_message=True)[2:]


def place(state):
    """Latitude and longitude in radians: a reference point and what the vessel is away from it."""
    north, east = state.x / EARTH_M, state.y / EARTH_M
    return state.lat + north, state.lon + east / math.cos(state.lat)


def away(here, north_m, east_m):
    return here[0] + north_m / EARTH_M, here[1] + east_m / EARTH_M / math.cos(here[0])


def metres(a, b):
    return math.hypot((a[0] - b[0]) * EARTH_M, (a[1] - b[1]) * EARTH_M * math.cos(a[0]))


def goto(point):
    return imc.Goto(0, point[0], point[1], 0.0, 1, 1.5, 0, 0.0, 0.0, 0.0, "")


def square(here, plan_id):
    points = [away(here, 20, 0), away(here, 20, 20), away(here, 0, 20)]
    names = ["wp1", "wp2", "wp3"]
    maneuvers = [imc.PlanManeuver(name, goto(point), [], []) for name, point in zip(names, points)]
    then = [imc.PlanTransition(a, b, "ManeuverIsDone", []) for a, b in zip(names, names[1:])]
    return imc.PlanSpecification(plan_id, "from pyimclsts", "", [], "wp1", maneuvers, then, [], [])


def pairs(text):
    return dict(part.split("=", 1) for part in text.split(";") if "=" in part)


# ---------------------------------------------------------------- the steps


def ready(console, shared):
    """in service, with a position"""
    console.wait("service", imc.VehicleState, lambda state: state.op_mode == SERVICE)
    state, _ = console.wait("a position", imc.EstimatedState, lambda state: abs(state.lat) > 0.01)
    shared["here"] = place(state)
    return f"at {math.degrees(shared['here'][0]):.6f}, {math.degrees(shared['here'][1]):.6f}"


def entities(console, shared):
    """EntityList query"""
    console.begin()
    console.send(imc.EntityList(1, ""))
    report, _ = console.wait("report", imc.EntityList, lambda reply: reply.op == 0)
    shared["entities"] = pairs(report.list)
    expect(to_us(report), f"the report goes to {report._header.dst:#06x}")
    numbers = set(shared["entities"].values())
    expect(len(numbers) == len(shared["entities"]), f"numbers stand twice in {report.list}")
    expect(shared["entities"].get("Daemon") == "0", f"the daemon is not 0 in {report.list}")
    unlisted = {str(message._header.src_ent) for _, message in console.seen if message._header.src == VESSEL}
    unlisted -= numbers | {"255"}
    expect(not unlisted, f"entities that send but are not listed: {unlisted}")
    known = ["Heading & Speed Controller", "Remote Control", "Path Control", "Navigation", "Plan Database",
             "Plan Engine", "GPS", "Motor - Port", "Motor - Starboard", "Vehicle Supervisor", "Logger"]  # fmt: skip
    missing = [label for label in known if label not in shared["entities"]]
    if missing:
        note(f"its labels that are not used here: {', '.join(missing)}")
    return f"{len(numbers)} entities"


def upload(console, shared):
    """PlanDB SET of a plan with 3 waypoints"""
    empty = console.database(5)[-1]
    expect(empty.arg.plan_count == 0 and empty.arg.md5 == hashlib.md5().digest(), f"not empty: {empty!r}")
    plan = shared["plan"] = square(shared["here"], "interop")
    replies = console.database(0, "interop", plan)
    expect([reply.type for reply in replies] == [IN_PROGRESS, SUCCESS], f"answers to SET: {replies!r}")
    expect(replies[-1].info == "OK (new entry)", f"text {replies[-1].info!r}")
    found = replies[-1].arg
    expect(isinstance(found, imc.PlanDBInformation), f"argument {found!r}")
    shared["md5"] = hashlib.md5(payload(plan)).digest()
    expect(found.md5 == shared["md5"], f"MD5 {found.md5.hex()}, by hashlib {shared['md5'].hex()}")
    expect(found.plan_size == len(payload(plan)), f"size {found.plan_size} of {len(payload(plan))}")
    expect(found.change_sid == CONSOLE, f"changed by {found.change_sid:#06x}")
    return f"{found.plan_size} bytes, MD5 {found.md5.hex()}"


def digest(console, shared):
    """PlanDB GET_STATE, GET, and a plan it does not have"""
    replies = console.database(5)
    state = replies[-1].arg
    expect(len(replies) == 1 and replies[0].type == SUCCESS, f"answers to GET_STATE: {replies!r}")
    expect(state.plan_count == 1 and len(state.plans_info) == 1, f"state {state!r}")
    expect(state.plans_info[0].md5 == shared["md5"], f"the plan's MD5 in the state {state.plans_info[0].md5.hex()}")
    whole = hashlib.md5(shared["md5"]).digest()
    expect(state.md5 == whole, f"MD5 of all {state.md5.hex()}, by hashlib {whole.hex()}")
    back = console.database(2, "interop")[-1].arg
    expect(payload(back) == payload(shared["plan"]), f"GET answers {back!r}")
    replies = console.database(1, "nowhere")
    kinds = [reply.type for reply in replies]
    expect(kinds[-1] == FAILURE and replies[-1].info == "undefined plan", f"DEL of nothing: {replies!r}")
    if kinds != [IN_PROGRESS, FAILURE]:
        note(f"answers DEL of an unknown plan by types 3, 2; here {[int(kind) for kind in kinds]}")
    return f"MD5 of all {state.md5.hex()}"


def refused(console, shared):
    """start of an unknown plan, stop of nothing"""
    number = console.ask(START, "nowhere")
    reply, _ = console.reply(number, FAILURE)
    expect(reply.info == "undefined plan", f"start of an unknown plan: {reply!r}")
    console.wait("outcome", imc.PlanControlState, lambda s: s.state == READY and s.last_outcome == 2)
    number = console.ask(STOP)
    reply, _ = console.reply(number, FAILURE)
    dune = "no plan is running, request ignored"
    if reply.info != dune:
        note(f"refuses a stop of nothing by {dune!r}, here {reply.info!r}")
    return f"'undefined plan', {reply.info!r}"


# What DUNE does at a start, in its order; whether this is asked of Lutra on the stream, too.
AT_START = [
    ("LogBookEntry 'request'", False, lambda m: isinstance(m, imc.LogBookEntry) and "request" in m.text),
    ("PlanControlState 2", True, lambda m: isinstance(m, imc.PlanControlState) and m.state == INITIALIZING),
    ("PlanControl 'plan loaded'", True, lambda m: isinstance(m, imc.PlanControl) and m.info == "plan loaded"),
    ("LoggingControl", False, lambda m: isinstance(m, imc.LoggingControl)),
    ("PlanSpecification", True, lambda m: isinstance(m, imc.PlanSpecification)),
    ("VehicleCommand 0", False, lambda m: isinstance(m, imc.VehicleCommand) and m.type == 0),
    ("VehicleCommand 1", False, lambda m: isinstance(m, imc.VehicleCommand) and m.type == 1),
    ("VehicleState 3", True, lambda m: isinstance(m, imc.VehicleState) and m.op_mode == MANEUVER),
    ("ControlLoops", False, lambda m: isinstance(m, imc.ControlLoops)),
    ("DesiredPath", False, lambda m: isinstance(m, imc.DesiredPath)),
    ("DesiredZ", False, lambda m: isinstance(m, imc.DesiredZ)),
    ("DesiredSpeed", False, lambda m: isinstance(m, imc.DesiredSpeed)),
    ("PathControlState", False, lambda m: isinstance(m, imc.PathControlState)),
    ("PlanControlState 3", True, lambda m: isinstance(m, imc.PlanControlState) and m.state == EXECUTING),
    ("PlanControl 'executing maneuver'", True,
     lambda m: isinstance(m, imc.PlanControl) and m.info == "wp1: executing maneuver"),
]  # fmt: skip


def begin_plan(console, shared):
    """PlanControl START: the sequence of replies"""
    number = shared["start"] = console.ask(START, "interop")
    sent = time.monotonic()
    loaded, _ = console.reply(number, SUCCESS, "plan loaded")
    expect(isinstance(loaded.arg, imc.PlanStatistics), f"argument of the first success: {loaded.arg!r}")
    expect("Total" in pairs(loaded.arg.durations), f"durations {loaded.arg.durations!r}")
    _, at = console.reply(number, SUCCESS, "wp1: executing maneuver")
    took = console.seen[at][0] - sent
    state, _ = console.wait("executing", imc.PlanControlState, lambda s: s.state == EXECUTING)
    expect(state.man_id == "wp1" and state.man_type == imc.Goto.Attributes.id, f"state {state!r}")
    expect(state.plan_id == "interop", f"state {state!r}")
    console.wait("maneuver", imc.VehicleState, lambda s: s.op_mode == MANEUVER and s.maneuver_type == 450)
    console.wait("regular path state", imc.PathControlState)
    plan = next(iter(console.since(imc.PlanSpecification)), None)
    expect(plan is not None, "the plan is not broadcast as it runs")
    expect(payload(plan) == payload(shared["plan"]), f"the plan as it runs: {plan!r}")
    came = {}
    for at, message in enumerate(console.since()):
        for name, _, is_it in AT_START:
            if name not in came and is_it(message):
                came[name] = at
    here = sorted(came, key=came.get)
    absent = [name for name, _, _ in AT_START if name not in came]
    must = [name for name, asked, _ in AT_START if asked]
    expect(not set(must) & set(absent), f"not seen: {', '.join(absent)}")
    replies = [name for name in here if name in must and "PlanSpec" not in name]
    early = ["PlanControlState 2", "PlanControl 'plan loaded'"]
    expect(replies[:2] == early, f"order {', '.join(replies)}")
    if absent:
        note(f"also sends {', '.join(absent)}")
    if here != [name for name, _, _ in AT_START if name in came]:
        note(f"has another order than here: {', '.join(here)}")
    return f"success twice, state 2 then 3, maneuver, after {took * 1000:.0f} ms: Total={pairs(loaded.arg.durations)['Total']} s"


def sail(console, shared):
    """the plan to its end, waypoint by waypoint"""
    begun = time.monotonic()
    for name in ["wp2", "wp3"]:
        console.wait(name, imc.PlanControlState, lambda s: s.state == EXECUTING and s.man_id == name, within=90)
    console.reply(shared["start"], SUCCESS, "plan completed", within=90)
    took = time.monotonic() - begun
    _, at = console.wait("ready", imc.PlanControlState, lambda s: s.state == READY and s.last_outcome == 1)
    console.wait("service", imc.VehicleState, lambda s: s.op_mode == SERVICE)
    done = [s for s in console.since(imc.VehicleState) if s.flags & 1]
    expect(done, "no VehicleState had the flag of a maneuver that is done")
    mine = [reply for reply in console.since(imc.PlanControl) if to_us(reply) and reply.type == SUCCESS]
    expect(len(mine) == 3, f"{len(mine)} successes, three with DUNE: {mine!r}")
    fast = max(state.u for state in console.since(imc.EstimatedState))
    expect(fast > 0.5, f"no faster than {fast:.2f} m/s")
    return f"a third success 'plan completed', outcome 1, after {took:.0f} s, up to {fast:.2f} m/s"


def follow(console, shared):
    """FollowReference: waiting, followed, timed out"""
    number = console.start("follow", imc.FollowReference(CONSOLE, 255, 3.0, 5.0, 0.0))
    console.wait("waiting", imc.FollowRefState, lambda state: state.state == 1)
    here = place(console.last(imc.EstimatedState))
    point = away(here, 60, -60)
    sent = []

    def reference():
        if not sent or time.monotonic() - sent[-1] >= 1.0:
            sent.append(time.monotonic())
            speed = imc.DesiredSpeed(1.2, 0)
            console.send(imc.Reference(1 | 2, speed, None, point[0], point[1], 0.0))

    console.mark = len(console.seen)
    state, _ = console.wait("followed", imc.FollowRefState, lambda s: s.state == 2, also=reference)
    expect(abs(state.reference.lat - point[0]) < 1e-12, f"the reference in the state: {state.reference!r}")
    expect(state.control_src == CONSOLE, f"controlled by {state.control_src:#06x}")
    before = metres(here, point)
    nearer = lambda s: metres(place(s), point) < before - 4
    last, at = console.wait("on its way", imc.EstimatedState, nearer, also=reference)
    states = len(console.since(imc.FollowRefState))
    if abs(states - len(sent)) > 1:
        note(f"sends one FollowRefState a Reference, here {states} for {len(sent)}")
    # And silence.
    console.wait("timeout", imc.FollowRefState, lambda s: s.state == 6)
    silent = time.monotonic() - sent[-1]
    expect(2.7 < silent < 4.2, f"timed out after {silent:.1f} s of 3")
    failed, _ = console.reply(number, FAILURE)
    expect("reference source timed out" in failed.info, f"failure {failed.info!r}")
    console.wait("service", imc.VehicleState, lambda s: s.op_mode == SERVICE, after=at)
    return f"{before - metres(place(last), point):.0f} m nearer, timeout after {silent:.1f} s: {failed.info!r}"


def thrusts(console, port, starboard, within=DEADLINE, also=lambda: None, after=None):
    """Waits until both motors are commanded so, in this order of arrival; tells when."""
    found = []
    for motor, value in [(0, port), (1, starboard)]:
        is_it = lambda set: set.id == motor and abs(set.value - value) < 0.02
        found.append(console.wait(f"thrust {motor}", imc.SetThrusterActuation, is_it, within, also, after)[1])
    return max(found)


def teleoperate(console, shared):
    """teleoperation by RemoteActions, and its watchdog"""
    console.start("teleoperation-mode", imc.Teleoperation(f"src={CONSOLE}"))
    state, _ = console.wait("state", imc.PlanControlState, lambda s: s.state == EXECUTING and s.man_type == 452)
    expect(state.plan_eta == -1, f"time left {state.plan_eta}")
    console.wait("loops", imc.VehicleState, lambda s: s.control_loops == 2 and s.op_mode == MANEUVER)
    console.begin()
    console.send(imc.RemoteActionsRequest(1, ""))
    report, _ = console.wait("actions", imc.RemoteActionsRequest, lambda reply: reply.op == 0)
    actions = pairs(report.actions)
    expect(actions.get("Port Motor") == "Axis" and actions.get("Exit") == "Button", f"actions {report.actions}")
    dune = {"Exit", "Port Motor", "Starboard Motor", "Accelerate", "Decelerate", "Heading", "Stop", "Ranges"}
    expect(dune <= set(actions), f"not offered: {dune - set(actions)}")
    sent = []

    def actions_from(source):
        def also():
            if not sent or time.monotonic() - sent[-1] >= 0.1:
                sent.append(time.monotonic())
                console.send(imc.RemoteActions("Port Motor=64;Starboard Motor=32"), src=source)

        return also

    # Somebody else moves nothing.
    console.begin()
    until = time.monotonic() + 0.8
    while time.monotonic() < until:
        actions_from(STRANGER)()
        console.receive(0.05)
    moved = [set for set in console.since(imc.SetThrusterActuation) if set.value != 0]
    expect(not moved, f"a stranger moved it: {moved!r}")
    # We do, for a second; then silence.
    console.begin()
    mine = actions_from(CONSOLE)
    thrusts(console, 64 / 127, 32 / 127, also=mine)
    until = time.monotonic() + 1.0
    while time.monotonic() < until:
        mine()
        console.receive(0.05)
    console.begin()
    zero = thrusts(console, 0, 0, within=5)
    silent = console.seen[zero][0] - sent[-1]
    expect(1.8 < silent < 2.4, f"thrust went to zero {silent:.2f} s after the last RemoteActions, 2.0 asked")
    console.begin()
    state, _ = console.wait("state", imc.PlanControlState)
    expect(state.state == EXECUTING, f"after the watchdog {state!r}")
    # The next message is obeyed again, and a stop ends it.
    thrusts(console, 64 / 127, 32 / 127, also=mine)
    number = console.ask(STOP)
    reply, at = console.reply(number, SUCCESS)
    if reply.info != "OK":
        note(f"answers a stop by 'OK', here {reply.info!r}")
    thrusts(console, 0, 0, within=1)
    console.wait("stopped", imc.PlanControlState, lambda s: s.state == READY and s.last_outcome == 2)
    return f"thrust 64/127 and 32/127, zero {silent:.2f} s after the last message, a stranger moves nothing"


def parameters(console, shared):
    """a parameter asked, changed, read back"""
    entity, name = "Path Control", "ILOS Lookahead Distance"

    def ask():
        console.begin()
        console.send(imc.QueryEntityParameters(entity, "user", "global"))
        reply, _ = console.wait("parameters", imc.EntityParameters, lambda reply: reply.name == entity)
        return {parameter.name: parameter.value for parameter in reply.params}

    def change(value):
        console.begin()
        console.send(imc.SetEntityParameters(entity, [imc.EntityParameter(name, value)]))

    before = ask()
    expect(name in before, f"parameters of {entity}: {before}")
    change("13")
    reply, _ = console.wait("changed", imc.EntityParameters, lambda reply: reply.name == entity)
    changed = {parameter.name: float(parameter.value) for parameter in reply.params}
    expect(changed == {name: 13.0}, f"answer to the change: {changed}")
    change("far")
    console.wait("a warning", imc.LogBookEntry, lambda entry: name in entry.text and entry.type in (1, 2))
    expect(not console.since(imc.EntityParameters), "a change that is no number was answered as taken")
    after = ask()
    expect(float(after[name]) == 13.0, f"{name} = {after[name]} after the change")
    others = {key for key in before if key != name and before[key] != after.get(key)}
    expect(not others, f"changed as well: {others}")
    return f"{name}: {before[name]} to {after[name]}, 'far' refused"


def abort(console, shared):
    """Abort in a plan"""
    here = place(console.last(imc.EstimatedState))
    plan = square(away(here, 100, 100), "aborted")
    number = console.start("aborted", plan)
    # It is told when the plan is on the disk, which may be after the start.
    stored, _ = console.wait("plan of the start", imc.PlanDB, lambda reply: reply.type == SUCCESS)
    expect(stored.arg.md5 == hashlib.md5(payload(plan)).digest(), f"plan of the start: {stored!r}")
    console.wait("way on", imc.SetThrusterActuation, lambda set: set.value > 0.1)
    console.begin()
    console.send(imc.Abort())
    failed, _ = console.reply(number, FAILURE)
    if "0x4001" not in failed.info.lower() and "16385" not in failed.info and "console" not in failed.info:
        note(f"names the sender in the failure, here {failed.info!r}")
    state, at = console.wait("error", imc.VehicleState, lambda state: state.op_mode == ERROR)
    expect(state.last_error, "no last_error")
    blocked = lambda s: s.state == BLOCKED and s.last_outcome == 2
    console.wait("blocked", imc.PlanControlState, blocked)
    thrusts(console, 0, 0, within=1)
    service, _ = console.wait("service", imc.VehicleState, lambda s: s.op_mode == SERVICE, after=at)
    # By the vessel's clock: a new log holds up the stream for a moment.
    took = service._header.timestamp - state._header.timestamp
    expect(0.95 < took < 1.4, f"in error for {took:.2f} s, 1.0 with DUNE")
    console.wait("ready", imc.PlanControlState, lambda s: s.state == READY, after=at)
    # What was commanded before the abort came may still have been on its way.
    aborted = state._header.timestamp
    thrust = [set for set in console.since(imc.SetThrusterActuation) if set._header.timestamp > aborted]
    expect(not any(set.value for set in thrust), f"thrust after the abort at {aborted}: {thrust!r}")
    return f"{failed.info!r}, error for {took:.2f} s, last_error {state.last_error!r}"


def stream(console, shared):
    """the stream as a whole"""
    echoes = [message for _, message in console.seen if message._header.src == CONSOLE]
    if not echoes:
        note("sends a console its own messages back; Lutra does not")
    late = sorted(console.late)
    expect(-0.005 < late[0] < 0.05, f"no packet arrives less than {late[0] * 1000:.0f} ms after its time")
    vessel = {message._header.src for _, message in console.seen} - {CONSOLE}
    expect(vessel == {VESSEL}, f"sources {vessel}")
    bytes_ = sum(message._header.size + 22 for _, message in console.seen)
    span = console.seen[-1][0] - console.seen[0][0]
    count = len(console.seen)
    return (f"{count} packets of {len(console.types)} types, CRC good, unpacked and packed again to the same bytes; "
            f"{count / span:.0f} packets/s, {bytes_ / span / 1000:.1f} kB/s; "
            f"{late[count // 2] * 1000:.0f} ms old at arrival, at most {late[-1] * 1000:.0f} ms")  # fmt: skip


STEPS = [ready, entities, upload, digest, refused, begin_plan, sail, follow, teleoperate, parameters, abort, stream]


def main():
    program, config = sys.argv[1:]
    with tempfile.TemporaryDirectory(prefix="lutra-interop-") as folder:
        agent, step = None, None
        try:
            agent = Agent(program, config, Path(folder))
            console, shared = Console(agent.tcp), {}
            for number, step in enumerate(STEPS, 1):
                console.begin() if step is not sail else None
                told = step(console, shared)
                print(f"{number:2}  ok  {step.__doc__}: {told}", flush=True)
            step = None
            print(f"    ok  SIGTERM: {agent.terminate()}")
        except Exception as failure:  # a reply of another form shows as an AttributeError or the like
            print(f"    FAILED  {step.__doc__ if step else 'the process'}: {failure or repr(failure)}")
            if not isinstance(failure, Differs):
                traceback.print_exc()
            return 1
        finally:
            said = agent.kill() if agent else ""
            if said:
                print(f"the agent said:\n{said}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
