"""Simulates a batch on clusters of 1 to thousands of cores from the measured times of a catalogue.

    python simulate.py OUT --files 100000 --plot scaling.png

It runs the planner of the batch itself (`trimtess.batch.plan`) against a model of Ray and storage. Assumptions:

1. Files: `--files` of them, drawn with replacement from the catalogue's rows with their sizes and seconds (seeded).
   Times are those of the cores that measured them, with one file per core, and include forking, hashing and writing.
2. Nodes of `--cores-per-node` cores. Memory does not limit how many files run at once.
3. The driver is one thread. It spends `--submit` to send a bundle, `--receive` to take one back, `--wait` per bundle
   under way each time that it takes one back, and `--row` per file for its row. It keeps two bundles per core under
   way, and sends the next when one comes back.
4. A bundle that was sent waits `--latency` for its worker, unless an earlier one is still in work there. Ray gives it
   to the core that is free first.
5. Every core spends `--start` once before its first file: starting the worker and the server.
6. Storage moves `--bandwidth` bytes a second over all nodes, inputs and outputs together, shared equally by all cores:
   a bundle takes at least as long as its bytes take at its cores' share.
7. No faults, and no other load.

Defaults of 3 to 5 were measured on 2 cores; docs/batch.md has the numbers and the check of 1 and 2 simulated cores
against real runs.
"""

from __future__ import annotations

import argparse
import dataclasses
import heapq
import json
import math
import pathlib
import random
import sys
from typing import Dict, List, Tuple

from trimtess.batch.catalogue import read
from trimtess.batch.drive import AHEAD
from trimtess.batch.plan import MIB, Bundle, Limits, Plan, predict
from trimtess.batch.sources import Source


@dataclasses.dataclass
class Model:
    """What Ray, storage and the driver cost, seconds and bytes a second."""

    submit: float
    receive: float
    wait: float
    row: float
    latency: float
    start: float
    bandwidth: float
    cores_per_node: int


@dataclasses.dataclass
class Files:
    """Files to convert: seconds on one core, and bytes in and out, by path."""

    sources: List[Source]
    seconds: Dict[str, float]
    bytes: Dict[str, int]


def draw(place: str, count: int, seed: int, slower: float) -> Files:
    """Draws files from a catalogue's rows. `count` 0: each row once. Seconds are multiplied by `slower`."""
    columns = ["size", "seconds", "outputs"]
    rows = [row for row in read(place)[1].select(columns).to_pylist() if row["size"] is not None and row["seconds"]]
    chance = random.Random(seed)
    drawn = chance.choices(rows, k=count) if count else rows
    sources = [Source(f"{number:08}", row["size"], "") for number, row in enumerate(drawn)]
    moved = [row["size"] + sum(output["bytes"] for output in row["outputs"] or ()) for row in drawn]
    names = [source.path for source in sources]
    return Files(sources, dict(zip(names, (slower * row["seconds"] for row in drawn))), dict(zip(names, moved)))


def simulate(files: Files, cores: int, model: Model) -> Dict[str, float]:
    """Runs the files on `cores` cores. Returns seconds to the last row, and the shares of time spent."""
    limits = Limits(4096 * MIB, 600.0, 2, 64 * MIB, model.cores_per_node)
    plan = Plan(files.sources, limits)
    free = [(model.start, core) for core in range(cores)]
    heapq.heapify(free)
    flying: List[Tuple[float, int, float, int, Bundle]] = []
    driver = busy = driving = 0.0
    bundles = 0
    while plan or flying:
        while plan and len(flying) < AHEAD * cores:
            bundle = plan.next(cores)
            driver += model.submit
            driving += model.submit
            taken = [heapq.heappop(free) for _ in range(min(bundle.cores, cores))]
            start = max(max(time for time, _ in taken), driver + model.latency)
            seconds = moved = done = 0
            while done < len(bundle.works) and seconds <= bundle.patience:
                path = bundle.works[done].source.path
                seconds, moved, done = seconds + files.seconds[path] / len(taken), moved + files.bytes[path], done + 1
            end = start + max(seconds, moved * cores / (len(taken) * model.bandwidth))
            busy += seconds * len(taken)
            for _, core in taken:
                heapq.heappush(free, (end, core))
            bundles += 1
            heapq.heappush(flying, (end, bundles, seconds, done, bundle))
        end, _, seconds, done, bundle = heapq.heappop(flying)
        spent = model.receive + model.wait * len(flying) + model.row * done
        driver = max(driver, end) + spent
        driving += spent
        plan.learn(bundle, done, seconds)
        plan.give_back(bundle.works[done:])
    return {
        "cores": cores,
        "seconds": driver,
        "files per second": len(files.sources) / driver,
        "efficiency": busy / (driver * cores),
        "driver busy": driving / driver,
        "bundles": bundles,
        "files per bundle": len(files.sources) / bundles,
    }


def plot(results: List[Dict[str, float]], path: str) -> None:
    """Files a second and efficiency over cores."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4), layout="constrained")
    speed, efficiency = figure.subplots(1, 2)
    cores = [result["cores"] for result in results]
    ideal = results[0]["files per second"] / cores[0]
    speed.plot(cores, [result["files per second"] for result in results], "o-", label="simulated")
    speed.plot(cores, [ideal * count for count in cores], "--", color="#888888", label="ideal")
    speed.set(xscale="log", yscale="log", xlabel="cores", ylabel="files a second")
    speed.legend()
    efficiency.plot(cores, [result["efficiency"] for result in results], "o-", label="cores in files")
    efficiency.plot(cores, [result["driver busy"] for result in results], "s-", label="driver busy")
    efficiency.set(xscale="log", xlabel="cores", ylabel="share of the time", ylim=(0, 1.05))
    efficiency.legend()
    figure.savefig(path, dpi=110)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("catalogue")
    parser.add_argument("--files", type=int, default=100_000, help="0: those of the catalogue (default: %(default)s)")
    parser.add_argument("--cores", default="1,2,4,8,16,32,64,128,256,512,1000,2000,4000")
    parser.add_argument("--slower", type=float, default=1.0, help="multiplies the seconds of files (default: 1)")
    parser.add_argument("--seed", type=int, default=14)
    parser.add_argument("--submit", type=float, default=0.0003, metavar="S")
    parser.add_argument("--receive", type=float, default=0.0006, metavar="S")
    parser.add_argument("--wait", type=float, default=6e-7, metavar="S")
    parser.add_argument("--row", type=float, default=4e-5, metavar="S")
    parser.add_argument("--latency", type=float, default=0.003, metavar="S")
    parser.add_argument("--start", type=float, default=1.5, metavar="S")
    parser.add_argument("--bandwidth", type=float, default=math.inf, metavar="BYTES", help="(default: no limit)")
    parser.add_argument("--cores-per-node", type=int, default=32)
    parser.add_argument("--plot", metavar="OUT.png")
    parser.add_argument("--rows", metavar="OUT.json")
    args = parser.parse_args()
    files = draw(args.catalogue, args.files, args.seed, args.slower)
    names = ("submit", "receive", "wait", "row", "latency", "start", "bandwidth", "cores_per_node")
    model = Model(**{name: getattr(args, name) for name in names})
    results = [simulate(files, int(cores), model) for cores in args.cores.split(",")]
    print("| cores | seconds | files/s | cores in files | driver busy | files per bundle |")
    print("|---|---|---|---|---|---|")
    for row in results:
        print(
            f"| {row['cores']} | {row['seconds']:.1f} | {row['files per second']:.1f} | {row['efficiency']:.1%} | "
            f"{row['driver busy']:.1%} | {row['files per bundle']:.1f} |"
        )
    total = sum(predict(source) for source in files.sources)
    print(f"{len(files.sources)} files, {sum(files.seconds.values()):.0f} s of work ({total:.0f} s predicted by size)")
    if args.plot:
        plot(results, args.plot)
    if args.rows:
        pathlib.Path(args.rows).write_text(json.dumps(results, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
