"""Measures what Ray and processes cost: the same files by a loop of the program, by the batch's server without
Ray, and by `trimtess-batch` on one core and on more.

    python overhead.py --program target/release/trimtess --cores 2 --rows rows.json FOLDER…

Prints a table. Every way writes GLB at the same tolerance with one thread per file. The loop writes a report
too (`--report`), since the catalogue has its numbers; it hashes nothing.
"""

from __future__ import annotations

import argparse
import json
import pathlib
import resource
import shlex
import subprocess
import sys
import tempfile
import time
from typing import Callable, Dict, List

from trimtess.batch import sources, task
from trimtess.batch.catalogue import read
from trimtess.batch.options import Options
from trimtess.batch.plan import MIB
from trimtess.batch.store import Store


def timed(work: Callable[[], object]) -> Dict[str, float]:
    """Wall and processor seconds of `work` and of the processes that it waited for."""
    before, start = processor(), time.perf_counter()
    work()
    return {"wall": time.perf_counter() - start, "processor": processor() - before}


def processor() -> float:
    usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


def shell_loop(paths: List[str], folder: pathlib.Path, program: str, jobs: int) -> Dict[str, float]:
    """A loop of the program: `xargs` starts it for one file after the other, `jobs` at once."""
    options = "-q --workers 1 --chord-rel 1e-3 --angle 20 --max-memory 4096"
    script = f'{shlex.quote(program)} tessellate "$0" {options} -o "$1.glb" --report "$1.json"'
    items = "\0".join(f"{path}\0{folder / str(number)}" for number, path in enumerate(paths)).encode()
    command = ["xargs", "-0", "-n", "2", "-P", str(jobs), "sh", "-c", script]
    return timed(lambda: subprocess.run(command, input=items, stderr=subprocess.DEVNULL))


def server_alone(paths: List[str], folder: pathlib.Path) -> Dict[str, float]:
    """One bundle of all files without Ray: forks, hashes, checks, renames."""
    store = Store(folder)
    store.start("run")
    job = {"out": str(folder), "run": "run", "options": Options().canonical()}
    job.update(seconds=600.0, max_memory=4096 * MIB, workers=1)
    import trimtess

    bundle = {"name": "0", "paths": paths, "version": trimtess.__version__, "patience": 1e9, "job": job}

    def work() -> None:
        task.run_bundle(bundle)
        # Its processor time counts once it has ended.
        task.SERVER.stop()

    result = timed(work)
    store.clear()
    return result


def batch(arguments: List[str], folder: pathlib.Path, cores: int) -> Dict[str, float]:
    """The program, with Ray's start and end; `work` is without them."""
    command = [sys.executable, "-m", "trimtess.batch", "convert", *arguments, "--out", str(folder), "-q"]
    result = timed(lambda: subprocess.run([*command, "--cores", str(cores)]))
    table = read(folder)[1]
    starts = [start.timestamp() for start in table["started"].to_pylist() if start]
    ends = [end.timestamp() for end in table["finished"].to_pylist() if end]
    result["work"] = max(ends) - min(starts)
    result["busy"] = sum(table["seconds"].to_pylist())
    return result


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", required=True)
    parser.add_argument("--cores", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=2, help="takes the fastest of so many, in turn")
    parser.add_argument("--rows", help="write all measurements as JSON")
    parser.add_argument("sources", nargs="+")
    args = parser.parse_args()
    paths = [source.path for source in sources.find(args.sources)]
    ways: Dict[str, Callable[[pathlib.Path], Dict[str, float]]] = {
        "loop of the program, 1 core": lambda out: shell_loop(paths, out, args.program, 1),
        f"loop of the program, {args.cores} cores": lambda out: shell_loop(paths, out, args.program, args.cores),
        "server without Ray": lambda out: server_alone(paths, out),
        "trimtess-batch, 1 core": lambda out: batch(args.sources, out, 1),
        f"trimtess-batch, {args.cores} cores": lambda out: batch(args.sources, out, args.cores),
    }
    rows: Dict[str, List[Dict[str, float]]] = {name: [] for name in ways}
    for _ in range(args.rounds):
        for name, way in ways.items():
            with tempfile.TemporaryDirectory() as folder:
                rows[name].append(way(pathlib.Path(folder)))
    print(
        "| way | wall s | first to last file s | processor s | files/s | files/s per core | in files, share of cores |"
    )
    print("|---|---|---|---|---|---|---|")
    for name, measured in rows.items():
        best = min(measured, key=lambda row: row.get("work", row["wall"]))
        work, cores = best.get("work", best["wall"]), args.cores if "cores" in name else 1
        busy = f"{best['busy'] / (cores * work):.1%}" if "busy" in best else ""
        speed = len(paths) / work
        # Ray's processes are nobody's children.
        spent = "" if "work" in best else f"{best['processor']:.1f}"
        print(f"| {name} | {best['wall']:.1f} | {work:.1f} | {spent} | {speed:.1f} | {speed / cores:.1f} | {busy} |")
    if args.rows:
        pathlib.Path(args.rows).write_text(json.dumps({"files": len(paths), "rows": rows}, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
