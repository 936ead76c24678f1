"""One bundle on a Ray worker: fetches its files, has the server convert each, and returns their outcomes."""

from __future__ import annotations

import concurrent.futures
import contextlib
import json
import os
import pathlib
import select
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from typing import Iterator, List, Optional, Tuple

import trimtess

from .errors import FULL, BatchError, DiskFull
from .options import Json
from .server import READY
from .store import Store

#: Seconds that a server may take longer than the time limit of a file before it counts as stuck.
PATIENCE = 60.0

#: Seconds that a server may take to load its modules, which hundreds of workers may fetch from one disk at once.
START_PATIENCE = 600.0

#: Libraries that would start threads in the server.
ONE_THREAD = {name: "1" for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")}


class ServerLost(Exception):
    """The server ended before it was ready."""


class Server:
    """The client's side of a server. Kept between bundles: starting one costs as much as tens of small files."""

    def __init__(self) -> None:
        self._process: Optional[subprocess.Popen[bytes]] = None

    def start(self) -> subprocess.Popen[bytes]:
        """The running server. Raises `ServerLost` if it ends before it is ready for a job."""
        if self._process is None:
            command = [sys.executable, "-m", "trimtess.batch.server"]
            environment = {**os.environ, **ONE_THREAD}
            self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment)
            if self._line(self._process, START_PATIENCE) != READY:
                raise ServerLost(self._end())
        return self._process

    def convert(self, job: Json) -> Json:
        """The outcome of a job. A server that was lost is started again for the next."""
        process = self.start()
        assert process.stdin, "it is a pipe"
        try:
            process.stdin.write(json.dumps(job).encode() + b"\n")
            process.stdin.flush()
            answer = self._line(process, job["seconds"] + PATIENCE)
        except BrokenPipeError:
            answer = b""
        if answer:
            outcome: Json = json.loads(answer)
            return outcome
        return {"status": "crashed", "message": self._end()}

    @staticmethod
    def _line(process: subprocess.Popen[bytes], seconds: float) -> bytes:
        """The next line that the server prints; nothing if it ended or takes longer."""
        assert process.stdout, "it is a pipe"
        ready, _, _ = select.select([process.stdout], [], [], seconds)
        return process.stdout.readline() if ready else b""

    def _end(self) -> str:
        """Ends a server that gave no answer. Returns what to say."""
        return f"the process that starts conversions was lost (status {self.stop()})"

    def stop(self) -> Optional[int]:
        """Kills the server, and its child with it. Returns its exit status."""
        if self._process is None:
            return None
        process, self._process = self._process, None
        process.kill()
        assert process.stdin and process.stdout, "both are pipes"
        with contextlib.suppress(BrokenPipeError):  # What was not read is still to be written.
            process.stdin.close()
        process.stdout.close()
        return process.wait()


#: The server of this Ray worker.
SERVER = Server()


class Marks:
    """Where a bundle is, on disk, so that the driver knows it when the worker is lost: two bytes for each file in the
    run's scratch folder, one as it begins and one as it ends."""

    def __init__(self, job: Json, name: str) -> None:
        self.path = scratch(job) / f"marks-{name}"
        self.descriptor = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)

    def __enter__(self) -> "Marks":
        return self

    def __exit__(self, error: object, *_: object) -> None:
        """Removes them if the worker is about to tell the outcomes."""
        os.close(self.descriptor)
        if not error:
            self.path.unlink(missing_ok=True)

    @contextlib.contextmanager
    def file(self) -> Iterator[None]:
        """Around the work on the next file. An error counts as its end: the worker lives."""
        os.write(self.descriptor, b"(")
        try:
            yield
        finally:
            os.write(self.descriptor, b")")

    @staticmethod
    def take(job: Json, name: str) -> Optional[int]:
        """The number of the file that a lost worker was at; `None` if it was between files. Removes the marks."""
        path = scratch(job) / f"marks-{name}"
        try:
            done, in_work = divmod(path.stat().st_size, 2)
            path.unlink()
        except FileNotFoundError:
            return None
        return done if in_work else None


def scratch(job: Json) -> pathlib.Path:
    """The run's scratch folder."""
    return Store(job["out"]).scratch(job["run"])


def run_bundle(bundle: Json) -> Json:
    """Converts the files of a bundle, one after the other.

    `bundle`: its `name` within the run, `paths`, `version` of the driver, `patience` in seconds, and what jobs have in
    common as `job`. Returns `outcomes`, one per file in order, and `host`, `node` and `seconds` of the bundle. There
    are fewer outcomes than files if the patience ended, the disk is full or the server does not start again. Raises
    `BatchError` if the worker cannot do any file. A worker that is lost leaves `Marks`.
    """
    start = time.perf_counter()
    check_worker(bundle)
    outcomes: List[Json] = []
    with Marks(bundle["job"], bundle["name"]) as marks:
        for path, local, failure, seconds in fetched(bundle):
            try:
                SERVER.start()
            except ServerLost:
                if outcomes:
                    break
                raise
            before = time.time()
            with marks.file():
                outcome = failure or SERVER.convert({**bundle["job"], "path": local})
            if outcome["status"] == "no-adapter":
                raise BatchError(f"worker {socket.gethostname()} cannot draw pictures: {outcome['message']}")
            outcome.update(path=path, started=before - seconds, finished=time.time())
            if seconds:
                outcome["seconds"] = {"fetch": seconds, **outcome.get("seconds", {})}
            outcomes.append(outcome)
            if outcome["status"] == "full" or time.perf_counter() - start > bundle["patience"]:
                break
    return {"outcomes": outcomes, "seconds": time.perf_counter() - start, **place()}


def place() -> Json:
    """Host and Ray node of this process. Outside Ray there is no node."""
    ray = sys.modules.get("ray")
    node = ray.get_runtime_context().get_node_id() if ray is not None and ray.is_initialized() else None
    return {"host": socket.gethostname(), "node": node}


def check_worker(bundle: Json) -> None:
    """Raises if this worker has another version of trimtess than the driver, or does not see the output folder."""
    if trimtess.__version__ != bundle["version"]:
        versions = f"trimtess {trimtess.__version__}, the driver has {bundle['version']}"
        raise BatchError(f"worker {socket.gethostname()} has {versions}")
    folder = scratch(bundle["job"])
    if not folder.is_dir():
        raise BatchError(f"worker {socket.gethostname()} does not see {folder}: --out must be a shared folder")


#: A file on this worker: path, local path, outcome if it could not be fetched, seconds that fetching took.
Fetched = Tuple[str, str, Optional[Json], float]


def fetched(bundle: Json) -> Iterator[Fetched]:
    """The files of a bundle. URLs are downloaded, one ahead of the file in work.

    A download is removed when the next file is asked for.
    """
    paths: List[str] = bundle["paths"]
    if not any(is_remote(path) for path in paths):
        yield from ((path, path, None, 0.0) for path in paths)
        return
    with contextlib.ExitStack() as stack:
        folder = pathlib.Path(tempfile.mkdtemp(dir=scratch(bundle["job"])))
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        ahead = stack.enter_context(concurrent.futures.ThreadPoolExecutor(1))
        pending = [ahead.submit(fetch, paths[0], folder / "0")]
        for number in range(len(paths)):
            done = pending.pop().result()
            if number + 1 < len(paths):
                pending.append(ahead.submit(fetch, paths[number + 1], folder / str(number + 1)))
            yield done
            pathlib.Path(done[1]).unlink(missing_ok=True)


def is_remote(path: str) -> bool:
    return "://" in path


def fetch(path: str, target: pathlib.Path) -> Fetched:
    """Downloads a URL."""
    import fsspec

    start = time.perf_counter()
    outcome = None
    try:
        system, name = fsspec.core.url_to_fs(path)
        system.get_file(name, str(target))
    except Exception as error:  # Each storage has exceptions of its own.
        if isinstance(error, OSError) and error.errno in FULL:
            raise DiskFull(str(target.parent), error.strerror or str(error)) from error
        reason = " ".join(str(error).split()) or "cannot be fetched"
        outcome = {"status": "unreadable", "message": f"{type(error).__name__}: {reason}"}
    return path, str(target), outcome, time.perf_counter() - start
