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

#: Seconds that a server may take longer than the time limit of a file before it counts as stuck.
PATIENCE = 60.0

#: Libraries that would start threads in the server.
ONE_THREAD = {name: "1" for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")}


class Server:
    """The client's side of a server. Kept between bundles: starting one costs as much as tens of small files."""

    def __init__(self) -> None:
        self._process: Optional[subprocess.Popen[bytes]] = None

    def convert(self, job: Json) -> Json:
        """The outcome of a job. A server that was lost is started again for the next."""
        process = self._process or self._start()
        assert process.stdin and process.stdout, "both are pipes"
        try:
            process.stdin.write(json.dumps(job).encode() + b"\n")
            process.stdin.flush()
            ready, _, _ = select.select([process.stdout], [], [], job["seconds"] + PATIENCE)
            answer = process.stdout.readline() if ready else b""
        except BrokenPipeError:
            answer = b""
        if answer:
            outcome: Json = json.loads(answer)
            return outcome
        code = self.stop()
        return {"status": "crashed", "message": f"the process that starts conversions was lost (status {code})"}

    def _start(self) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "trimtess.batch.server"]
        environment = {**os.environ, **ONE_THREAD}
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment)
        return self._process

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


def run_bundle(bundle: Json) -> Json:
    """Converts the files of a bundle, one after the other.

    `bundle`: `paths`, `version` of the driver, `patience` in seconds, and what jobs have in common as `job`. Returns
    `outcomes`, one per file in order, and `host`, `node` and `seconds` of the bundle. There are fewer outcomes than
    files if the patience ended or the disk is full. Raises `BatchError` if the worker cannot do any file.
    """
    start = time.perf_counter()
    check_worker(bundle)
    outcomes = []
    for path, local, failure, seconds in fetched(bundle):
        before = time.time()
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
    scratch = pathlib.Path(bundle["job"]["out"], ".tmp", bundle["job"]["run"])
    if not scratch.is_dir():
        raise BatchError(f"worker {socket.gethostname()} does not see {scratch}: --out must be a shared folder")


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
        scratch = pathlib.Path(bundle["job"]["out"], ".tmp", bundle["job"]["run"])
        folder = pathlib.Path(tempfile.mkdtemp(dir=scratch))
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
