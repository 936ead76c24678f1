"""Kills processes of a run at random moments, and compares what came out with a run without faults."""

from __future__ import annotations

import collections
import hashlib
import os
import pathlib
import random
import subprocess
import tempfile
import time
from typing import Counter, Dict, List, Set

import psutil
import pyarrow.parquet

from trimtess.batch.cluster import FOLDER

from .running import command

#: Columns that say what a file cost and where, which differ between runs.
COSTS = ("seconds", "peak_memory", "memory_limit", "attempts", "host", "started", "finished", "run", "reused", "cores")

#: Words in the command lines of processes that may be killed, and what they are.
VICTIMS = {"ray::": "Ray worker", "trimtess.batch.server": "server or conversion"}

#: Processes of Ray without which no run goes on. Killing them is killing the machine.
SPARED = ("Agent", "raylet", "gcs_server", "log_monitor", "monitor.py", "dashboard.py")


def rows(out: pathlib.Path) -> List[dict]:
    """All rows, straight from the Parquet files."""
    found = []
    for segment in sorted((out / "catalogue").glob("*.parquet")):
        found += pyarrow.parquet.read_table(segment).to_pylist()
    return found


def without_costs(row: dict) -> dict:
    return {name: value for name, value in row.items() if not name.startswith(COSTS)}


def objects(out: pathlib.Path) -> Dict[str, str]:
    """SHA-256 of each output by its path."""
    files = (path for path in (out / "objects").rglob("*") if path.is_file() and path.name != "result.json")
    return {str(path.relative_to(out)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def compare(reference: pathlib.Path, out: pathlib.Path) -> None:
    """Fails unless every file has one row, equal but for its costs, and every output is equal."""
    counts = collections.Counter(row["path"] for row in rows(out))
    assert {path for path, count in counts.items() if count != 1} == set()
    expected = {row["path"]: without_costs(row) for row in rows(reference)}
    found = {row["path"]: without_costs(row) for row in rows(out)}
    assert expected.keys() == found.keys()
    for path in expected:
        assert expected[path] == found[path]
    listed = {output["path"]: output["sha256"] for row in rows(out) for output in row["outputs"] or ()}
    assert listed == objects(out) == objects(reference)


def ray_folders() -> Set[str]:
    """Folders of embedded Rays, of whatever run."""
    return {str(path) for path in pathlib.Path(tempfile.gettempdir()).glob(FOLDER + "*")}


def leftovers(out: pathlib.Path, folders_before: Set[str]) -> List[str]:
    """What a run left that it should not have: hidden files, folders of Ray, processes."""
    found = [str(path) for path in out.rglob("*") if path.name.startswith(".") or path.name.endswith(".part")]
    found += [str(path) for path in out.iterdir() if path.name not in ("objects", "catalogue")]
    found += ray_folders() - folders_before
    for process in psutil.process_iter(["cmdline", "status"]):
        line = " ".join(process.info["cmdline"] or ())
        if "trimtess.batch" in line and process.info["status"] != psutil.STATUS_ZOMBIE and str(out) in line:
            found.append(line)
        if "trimtess.batch.server" in line and process.ppid() == 1:
            found.append(line)
    return found


def victims(driver: psutil.Process) -> "List[tuple[psutil.Process, str]]":
    found = []
    for process in driver.children(recursive=True):
        try:
            line = " ".join(process.cmdline())
        except psutil.Error:
            continue
        kind = next((kind for words, kind in VICTIMS.items() if words in line), None)
        if kind and not any(spared in line for spared in SPARED):
            found.append((process, kind))
    return found


def run_under_fire(
    arguments: List[object], out: pathlib.Path, chance: random.Random, driver_kills: int, pause: float, life: int
) -> Counter[str]:
    """Runs `convert` until it ends by itself, restarting it each time that it is killed.

    Every `pause` seconds in the mean a random process of the run is killed; the driver itself `driver_kills` times,
    after up to `life` results. Returns how many of each kind were killed.
    """
    killed: Counter[str] = collections.Counter()
    while True:
        start = count_results(out)
        end = start + chance.randint(1, life)
        running = subprocess.Popen(command("convert", *arguments, "--out", out, "-q"))
        driver = psutil.Process(running.pid)
        next_kill = 0.0
        while running.poll() is None:
            time.sleep(0.01)
            results = count_results(out)
            if killed["driver"] < driver_kills and results >= end:
                running.kill()
                killed["driver"] += 1
                break
            if results > start and time.monotonic() > next_kill:
                next_kill = time.monotonic() + chance.expovariate(1.0 / pause)
                killed.update(kill_one(driver, chance))
        if running.wait() >= 0:
            assert running.returncode in (0, 3), running.returncode
            return killed


def kill_one(driver: psutil.Process, chance: random.Random) -> List[str]:
    """Kills a process of the run, if there is one, and says of which kind it was."""
    try:
        target, kind = chance.choice(victims(driver))
        target.kill()
        return [kind]
    except (IndexError, psutil.Error):
        return []


def count_results(out: pathlib.Path) -> int:
    return len(list((out / "objects").glob("*/*")))


def made(out: pathlib.Path) -> Dict[str, int]:
    """When each result was made."""
    return {path.name: path.stat().st_mtime_ns for path in (out / "objects").glob("*/*")}


def can_mount() -> bool:
    """Whether this user may mount a file system of its own, in a name space of its own."""
    try:
        return subprocess.run([*NAMESPACE, "true"], capture_output=True).returncode == 0
    except FileNotFoundError:
        return False


NAMESPACE = ["unshare", "--user", "--map-root-user", "--mount"]


def run_on_small_disk(arguments: List[object], out: pathlib.Path, size: str) -> "subprocess.CompletedProcess[str]":
    """Runs `convert` with an output folder on a file system of `size`, then copies that to `out`."""
    out.mkdir(parents=True)
    disk = pathlib.Path(tempfile.mkdtemp(dir=out.parent))
    script = 'disk=$1 size=$2 out=$3; shift 3; mount -t tmpfs -o size="$size" tmpfs "$disk" || exit 99; "$@"; status=$?'
    script += '; cp -a "$disk/." "$out"; exit $status'
    convert = command("convert", *arguments, "--out", disk, "-q")
    done = subprocess.run(
        [*NAMESPACE, "sh", "-c", script, "sh", str(disk), size, str(out), *convert], capture_output=True, text=True
    )
    os.rmdir(disk)
    return done
