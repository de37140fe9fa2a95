"""The shortest way over a grid by other planners: bench_routes.py GRID, which the bench of routes wrote."""

import json
import math
import os
import pathlib
import resource
import sys
import time

import numpy
import pyastar2d
from skimage.graph import MCP_Geometric

ROUNDS = 5
# The water that the file is of.
WATER = pathlib.Path(sys.argv[1]).name


def length_m(way, spacing_m):
    """Of a way over middles of cells."""
    return spacing_m * sum(math.dist(one, other) for one, other in zip(way[:-1], way[1:]))


def measure(name, spacing_m, find):
    took_s = []
    for _ in range(ROUNDS):
        begun = time.perf_counter()
        way = find()
        took_s.append(time.perf_counter() - begun)
    first_ms, again_ms = took_s[0] * 1e3, sorted(took_s)[ROUNDS // 2] * 1e3
    print(f"  {name}: {length_m(way, spacing_m):.1f} m, {again_ms:.0f} ms")
    if table := os.environ.get("LUTRA_TABLE"):
        most_mib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10
        row = [WATER, name, "-", f"{first_ms:.2f}", f"{again_ms:.2f}", f"{length_m(way, spacing_m):.1f}", "-", str(most_mib)]
        with open(table, "a", encoding="utf-8") as file:
            print(*row, sep="\t", file=file)


def main():
    with open(sys.argv[1], "rb") as file:
        head = json.loads(file.readline())
        cells = numpy.frombuffer(file.read(), dtype=numpy.uint8).reshape(head["rows"], head["columns"])
    start, goal = (tuple(reversed(head[end])) for end in ("from", "to"))
    spacing_m = head["spacing_m"]
    costs = numpy.where(cells == 1, 1.0, numpy.inf).astype(numpy.float32)
    closed = numpy.where(cells == 1, 1.0, -1.0)

    def by_mcp():
        search = MCP_Geometric(closed)
        search.find_costs([start], [goal])
        return search.traceback(goal)

    print(f"{WATER}, the same cells, 8 neighbours:")
    measure("scikit-image, MCP_Geometric, 8 neighbours", spacing_m, by_mcp)
    measure("pyastar2d, 8 neighbours", spacing_m, lambda: pyastar2d.astar_path(costs, start, goal, allow_diagonal=True))


main()
