"""How fast pyimclsts reads a log: every packet's CRC checked and every message decoded, best of three."""

import sys
import time

from pyimclsts import core, network

data = open(sys.argv[1], "rb").read()
best, packets = float("inf"), 0
for _ in range(3):
    start, at, packets = time.perf_counter(), 0, 0
    while at + 20 <= len(data):
        size = int.from_bytes(data[at + 4 : at + 6], "little")
        packet = data[at : at + size + 22]
        if core.CRC16IMB(packet[:-2]) != int.from_bytes(packet[-2:], "little"):
            sys.exit(f"bad CRC at {at}")
        network.unpack(packet)
        packets += 1
        at += size + 22
    best = min(best, time.perf_counter() - start)
print(f"pyimclsts, every message decoded: {packets} packets, {packets / best:.0f} packets/s, {len(data) / best / 1e6:.2f} MB/s")
