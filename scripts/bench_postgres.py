"""Carries the recording of a DUNE vehicle, repeated, to a PostgreSQL as it is made by initdb (fsync on), and measures until all of it is
committed there. Server and PostgreSQL share the computer's processors."""

import gzip
import os
import pathlib
import pwd
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import urllib.request

REPEATS = int(os.environ.get("LUTRA_REPEATS", "17"))
HEADER, FOOTER = 20, 2


def crc_table():
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = byte >> 1 ^ (0xA001 if byte & 1 else 0)
        table.append(byte)
    return table


CRC = crc_table()


def crc16(data):
    crc = 0
    for byte in data:
        crc = crc >> 8 ^ CRC[(crc ^ byte) & 0xFF]
    return crc


def repeated(log, out):
    """Writes the log REPEATS times, each later by its length; how many packets."""
    data = bytearray(gzip.decompress(log.read_bytes()))
    packets, at = [], 0
    while at < len(data):
        size, stamp = struct.unpack_from("<Hd", data, at + 4)
        end = at + HEADER + size + FOOTER
        packets.append((at, end, stamp))
        at = end
    length_s = max(p[2] for p in packets) - min(p[2] for p in packets) + 1
    with open(out, "wb") as file:
        for repeat in range(REPEATS):
            for at, end, stamp in packets:
                struct.pack_into("<d", data, at + 6, stamp + repeat * length_s)
                struct.pack_into("<H", data, end - FOOTER, crc16(data[at : end - FOOTER]))
            file.write(data)
    return len(packets) * REPEATS


class Postgres:
    def __init__(self, folder):
        self.folder = folder
        self.bin = max(pathlib.Path("/usr/lib/postgresql").glob("*/bin"))
        self.user = {}
        if os.getuid() == 0:
            user = pwd.getpwnam("postgres")
            os.chown(folder, user.pw_uid, user.pw_gid)
            self.user = {"user": user.pw_uid, "group": user.pw_gid, "extra_groups": []}
        self.tool("initdb", "-D", folder / "data", "-U", "postgres", "-A", "trust", "-E", "UTF8")
        options = f"-p 55432 -c listen_addresses= -c unix_socket_directories={folder}"
        self.tool("pg_ctl", "-D", folder / "data", "-l", folder / "log", "-o", options, "-w", "start")
        self.psql("CREATE ROLE lutra LOGIN", "postgres")
        self.psql("CREATE DATABASE boats OWNER lutra", "postgres")

    def tool(self, name, *arguments):
        command = [self.bin / name, *arguments]
        subprocess.run(command, check=True, cwd=self.folder, stdout=subprocess.DEVNULL, **self.user)

    def psql(self, sql, database="boats"):
        command = [self.bin / "psql", "-h", self.folder, "-p", "55432", "-U", "postgres", "-d", database, "-Atc", sql]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()

    def stop(self):
        self.tool("pg_ctl", "-D", self.folder / "data", "-m", "immediate", "-w", "stop")


def waiting(web):
    """Bytes that wait to be carried."""
    try:
        figures = urllib.request.urlopen(f"http://{web}/metrics").read().decode()
    except OSError:
        return None
    found = re.search(r'lutra_sink_waiting_bytes\{sink="postgres"\} (\S+)', figures)
    return float(found[1]) if found else None


def carried(server, data, folder):
    """Starts a server and waits until everything is there; how long that took (s)."""
    url = f"postgres://{str(folder).replace('/', '%2F')}:55432/boats"
    command = [server, "serve", "--listen", "127.0.0.1:0", "--set", "imc.active=false", "--set", f"sinks.postgres.url={url}"]
    command += ["--set", "sinks.postgres.user=lutra", "--data", data]
    with open(data.parent / "server.log", "wb") as log:
        process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT)
    try:
        web = None
        while web is None:
            text = (data.parent / "server.log").read_text()
            web = re.search(r"127\.0\.0\.1:\d+", text)
            time.sleep(0.01)
        begun = time.monotonic()
        while waiting(web[0]) != 0:
            if process.poll() is not None:
                sys.exit((data.parent / "server.log").read_text())
            time.sleep(0.05)
        return time.monotonic() - begun
    finally:
        process.terminate()
        process.wait()


def main():
    server, log = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    scratch = pathlib.Path(tempfile.mkdtemp(dir="/tmp"))
    scratch.chmod(0o755)
    folder = scratch / "postgres"
    folder.mkdir()
    postgres = None
    try:
        count = repeated(log, scratch / "Data.lsf")
        subprocess.run([server, "import", scratch / "Data.lsf", "--data", scratch / "data"], check=True, stdout=subprocess.DEVNULL)
        postgres = Postgres(folder)
        took_s = carried(server, scratch / "data", folder)
        rows = int(postgres.psql("SELECT sum(n_tup_ins) FROM pg_stat_user_tables"))
        bytes_ = int(postgres.psql("SELECT pg_database_size('boats')"))
        print(f"load of the machine after: {pathlib.Path('/proc/loadavg').read_text().strip()}")
        print(f"{count} messages in {took_s:.1f} s: {count / took_s:.0f} messages/s, committed with fsync; {rows} rows inserted, {bytes_ / 1e6:.0f} MB")
        (scratch / "data/sinks/postgres.json").unlink()
        took_s = carried(server, scratch / "data", folder)
        print(f"all of it once more, which changes nothing: {count / took_s:.0f} messages/s")
    finally:
        if postgres:
            postgres.stop()
        shutil.rmtree(scratch)


main()
