"""The driver: deals bundles to Ray, takes outcomes back, and records each file's row once.

A row is recorded after the result is in the store. A run that is killed in between finds the result there again, so
nothing is converted twice.
"""

from __future__ import annotations

import collections
import dataclasses
import os
import pathlib
import random
import signal
import socket
import time
import uuid
from typing import Any, Counter, Dict, Iterable, List, Optional, Tuple

import trimtess

from . import cluster as clusters
from . import sources, task
from .catalogue import Catalogue, failure, row
from .convert import STORED
from .errors import FULL, BatchError, DiskFull, Interrupted
from .options import Json, Options
from .plan import MIB, Bundle, Limits, Plan, Work, predict
from .progress import Meter
from .store import Store

#: Most seconds and rows between two segments of the catalogue.
FLUSH_SECONDS, FLUSH_ROWS = 5.0, 2000

#: Memory that a file may take unless the caller says: what 50 MB of STEP need.
DEFAULT_MEMORY = 4096 * MIB

#: Seconds without any node after which a run gives up.
LOST_SECONDS = 30.0

#: Workers lost in a row while they were at no file, after which a run gives up.
MOST_LOST_IDLE = 100

#: Bundles under way, per core: one in work and one that waits for the worker.
AHEAD = 2


@dataclasses.dataclass
class Settings:
    """What does not change outputs."""

    address: Optional[str] = None
    #: Cores of an embedded Ray; `None` for all.
    cores: Optional[int] = None
    #: Bytes that a file's process may take; `None` for `DEFAULT_MEMORY` or what the largest node has.
    max_memory: Optional[int] = None
    #: Seconds that a file may take.
    seconds: float = 600.0
    retries: int = 2
    #: Bytes from which on a file gets several cores.
    large: int = 64 * MIB
    #: Convert files again that failed for a reason that may have passed.
    retry_failed: bool = False
    quiet: bool = False


@dataclasses.dataclass
class Summary:
    """What a run did."""

    #: Files that the arguments named, and those that had their row before.
    files: int
    known: int
    #: Files by status, earlier runs included.
    statuses: Dict[str, int]
    #: Seconds from the first task to the last row.
    seconds: float


def convert(arguments: Iterable[str], out: "os.PathLike[str] | str", options: Options, settings: Settings) -> Summary:
    """Converts all sources that have no row yet. Raises `BatchError` if the run cannot go on."""
    out = pathlib.Path(out).absolute()
    found = sources.find(arguments)
    run = uuid.uuid4().hex[:12]
    with Catalogue.open(out, options.canonical()) as catalogue:
        statuses: Counter[str] = collections.Counter()
        todo = outstanding(found, catalogue, settings.retry_failed, statuses)
        known = len(found) - len(todo)
        seconds = 0.0
        store = Store(out)
        left = left_behind(catalogue.killed)
        clusters.remove_folders(left)
        try:
            store.start(run)
        except OSError as error:
            raise failure(out, error) from error
        try:
            if todo:
                seconds = convert_all(todo, out, run, options, settings, catalogue, statuses, left)
        finally:
            store.clear()
            # Again, for a worker that outlived the wait.
            clusters.remove_folders(left)
        return Summary(len(found), known, dict(statuses), seconds)


def outstanding(
    found: List[sources.Source], catalogue: Catalogue, retry_failed: bool, statuses: Counter[str]
) -> List[sources.Source]:
    """The sources to convert: those without a row, and those whose row is removed here because they changed or are
    to be tried again. Counts the statuses of the others."""
    known = catalogue.known()
    todo, outdated = [], []
    for source in found:
        before = known.get(source.path)
        if before is None:
            todo.append(source)
            continue
        changed = (before["size"], before["stamp"]) != (source.size, source.stamp)
        if changed or (retry_failed and before["status"] not in STORED):
            todo.append(source)
            outdated.append(source.path)
        else:
            statuses[before["status"]] += 1
    if outdated:
        catalogue.remove(outdated)
    return todo


def left_behind(killed: Json) -> List[str]:
    """Folders of Ray that a run on this host left when it was killed."""
    return killed.get("ray", []) if killed.get("host") == socket.gethostname() else []


def convert_all(
    todo: List[sources.Source],
    out: pathlib.Path,
    run: str,
    options: Options,
    settings: Settings,
    catalogue: Catalogue,
    statuses: Counter[str],
    left: List[str],
) -> float:
    """Converts sources on Ray. Returns seconds. `left`: folders that the next run removes if this one is killed."""
    folder = clusters.new_folder() if settings.address is None else None
    catalogue.note({"pid": os.getpid(), "host": socket.gethostname(), "ray": [*left, *filter(None, [folder])]})
    with clusters.connected(settings.address, settings.cores, folder) as cluster:
        plan = Plan(todo, limits(settings, cluster))
        job = {"out": str(out), "run": run, "options": options.canonical(), "seconds": settings.seconds}
        meter = Meter(len(todo), plan.seconds_left, settings.quiet)
        try:
            return Driver(plan, job, catalogue, statuses, meter).run()
        finally:
            meter.close()


def limits(settings: Settings, cluster: clusters.Cluster) -> Limits:
    """The limits that this cluster can keep. Raises if a file may take more memory than any node has."""
    most = cluster.memory_of_largest
    memory = settings.max_memory or min(DEFAULT_MEMORY, most)
    if memory > most:
        raise BatchError(f"--max-memory {memory // MIB}: the largest node has {most // MIB} MiB")
    return Limits(memory, settings.seconds, settings.retries, settings.large, cluster.cores_of_largest)


class Driver:
    """One run over a plan."""

    def __init__(self, plan: Plan, job: Json, catalogue: Catalogue, statuses: Counter[str], meter: Meter) -> None:
        import ray

        self.ray: Any = ray
        self.remote = ray.remote(max_retries=0)(task.run_bundle)
        self.plan, self.job, self.catalogue, self.statuses, self.meter = plan, job, catalogue, statuses, meter
        #: Bundles under way, and their names.
        self.flying: Dict[object, Tuple[Bundle, str]] = {}
        self.launched = self.lost_idle = 0
        self.rows: List[Json] = []
        self.flushed = self.seen = time.monotonic()
        self.stop: Optional[int] = None

    def run(self) -> float:
        """Works until nothing is left. Rows are flushed however it ends."""
        start = time.monotonic()
        # After Ray's start, which has handlers of its own.
        before = {number: signal.signal(number, self.interrupt) for number in (signal.SIGINT, signal.SIGTERM)}
        try:
            while self.plan or self.flying:
                if self.stop is not None:
                    raise Interrupted(self.stop)
                self.launch()
                self.land_all()
                if len(self.rows) >= FLUSH_ROWS or time.monotonic() - self.flushed >= FLUSH_SECONDS:
                    self.flush()
        finally:
            self.cancel()
            for number, handler in before.items():
                signal.signal(number, handler)
            self.flush()
        return time.monotonic() - start

    def interrupt(self, number: int, _frame: object) -> None:
        self.stop = number

    def launch(self) -> None:
        """Keeps the cluster busy."""
        slots = self.count_slots()
        while self.plan and len(self.flying) < AHEAD * slots:
            bundle, name = self.plan.next(slots), str(self.launched)
            self.launched += 1
            job = {**self.job, "max_memory": bundle.memory, "workers": bundle.cores}
            data = {
                "name": name,
                "paths": [work.source.path for work in bundle.works],
                "version": trimtess.__version__,
                "patience": bundle.patience,
                "job": job,
            }
            asked = {"num_cpus": bundle.cores, "memory": bundle.memory, **self.elsewhere(bundle)}
            self.flying[self.remote.options(**asked).remote(data)] = bundle, name

    def count_slots(self) -> int:
        """Cores of the cluster, which may grow and shrink. Raises once there have been none for a while."""
        slots = int(self.ray.cluster_resources().get("CPU", 0))
        if slots > 0:
            self.seen = time.monotonic()
        elif time.monotonic() - self.seen > LOST_SECONDS:
            raise BatchError("Ray lost all of its nodes; run the same command again to continue")
        return max(1, slots)

    def elsewhere(self, bundle: Bundle) -> Json:
        """Options that place a retry on another node than the one where it failed, if there is one."""
        failed = {work.node for work in bundle.works} - {None}
        if not failed:
            return {}
        others = [node["NodeID"] for node in self.ray.nodes() if node["Alive"] and node["NodeID"] not in failed]
        if not others:
            return {}
        from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

        return {"scheduling_strategy": NodeAffinitySchedulingStrategy(random.choice(others), soft=True)}

    def land_all(self) -> None:
        """Takes the bundles back that are done; waits half a second for the first."""
        refs = list(self.flying)
        if self.ray.wait(refs, num_returns=1, timeout=0.5)[0]:
            for ref in self.ray.wait(refs, num_returns=len(refs), timeout=0)[0]:
                self.land(ref)

    def land(self, ref: object) -> None:
        """Takes one bundle back."""
        bundle, name = self.flying.pop(ref)
        try:
            answer = self.ray.get(ref)
        except self.ray.exceptions.RayError as error:
            self.stop_if_hopeless(getattr(error, "cause", None))
            self.lose(bundle, task.Marks.take(self.job, name), clusters.one_line(error))
            return
        self.lost_idle = 0
        done = len(answer["outcomes"])
        self.plan.learn(bundle, done, answer["seconds"])
        self.plan.give_back(bundle.works[done:])
        for work, outcome in zip(bundle.works, answer["outcomes"]):
            if outcome["status"] == "full":
                raise DiskFull(self.job["out"], outcome["message"])
            if outcome["status"] in STORED or not self.plan.failed(
                work, outcome["status"], bundle.memory, answer["node"]
            ):
                self.record(work, outcome, bundle, answer["host"])

    def lose(self, bundle: Bundle, at: Optional[int], reason: str) -> None:
        """Deals the files of a bundle again whose worker was lost, while at file `at` or at none. Raises if that happens
        at none again and again: no file is to blame, and the run would never end."""
        self.lost_idle = self.lost_idle + 1 if at is None else 0
        if self.lost_idle > MOST_LOST_IDLE:
            raise BatchError(f"{self.lost_idle} workers in a row were lost while they were at no file: {reason}")
        for work in self.plan.lost(bundle, at):
            message = f"its worker was lost {work.losses} times: {reason}"
            self.record(work, {"status": "lost", "message": message}, bundle, None)

    def stop_if_hopeless(self, cause: Optional[BaseException]) -> None:
        """Raises for causes of a failed task that every further task would meet."""
        if isinstance(cause, BatchError):
            raise cause
        if isinstance(cause, ImportError):
            raise BatchError(f"a worker cannot import what it needs: {clusters.one_line(cause)}")
        if isinstance(cause, OSError) and cause.errno in FULL:
            raise DiskFull(self.job["out"], cause.strerror or str(cause))

    def record(self, work: Work, outcome: Json, bundle: Bundle, host: Optional[str]) -> None:
        """Notes the row of a file that is done."""
        attempts = work.attempts + work.losses + (outcome["status"] in STORED)
        extra = {"attempts": attempts, "host": host, "run": self.job["run"], "memory_limit": bundle.memory}
        source = work.source
        self.rows.append(row(source.path, source.size, source.stamp, outcome, extra))
        self.statuses[outcome["status"]] += 1
        self.meter.advance(1, outcome["status"] not in ("whole", "partial"), predict(source))

    def flush(self) -> None:
        """Appends the rows to the catalogue."""
        rows, self.rows = self.rows, []
        self.catalogue.append(rows)
        self.flushed = time.monotonic()

    def cancel(self) -> None:
        """Ends the bundles under way, and waits for them, so that nobody writes to the scratch folder."""
        for ref in self.flying:
            self.ray.cancel(ref, force=True)
        if self.flying:
            self.ray.wait(list(self.flying), num_returns=len(self.flying), timeout=10)
