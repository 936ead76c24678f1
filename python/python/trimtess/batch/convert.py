"""One file to one result: what the process of a source does.

The result depends on the input's bytes, the options and the version of trimtess alone, so that it can be named by
their hash. Seconds and memory tell what its making cost.
"""

from __future__ import annotations

import collections
import hashlib
import pathlib
import time
from typing import Callable, Dict, Iterator, Optional

import trimtess

from .errors import FULL
from .options import Json, Options, result_key
from .store import Store, describe

#: Statuses of a result that is stored: the same for every run over the same input.
STORED = ("whole", "partial", "refused")


class Stopwatch:
    """Seconds per stage."""

    def __init__(self) -> None:
        self.seconds: Dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, stage: str) -> None:
        now = time.perf_counter()
        self.seconds[stage] = self.seconds.get(stage, 0.0) + now - self._last
        self._last = now


def convert(job: Json) -> Json:
    """Converts a file and stores its result. Returns the outcome as JSON data.

    `job`: `path` of a local file, `out` folder, `run`, `options` (canonical), `max_memory` in bytes, `workers`.
    The outcome has a `status`:

    * `whole`, `partial` (a face has a warning or error, there is none, or the check failed), `refused`: stored,
    * `limit`: needs more memory than `max_memory`,
    * `unreadable`: the file cannot be opened,
    * `full`: there is no room for the outputs,
    * `no-adapter`: pictures are asked for, and this machine cannot draw,
    * `crashed`: another error of the system.

    Raises for what is a fault of the program, and `MemoryError`: `server.death` turns both into outcomes.
    """
    watch = Stopwatch()
    try:
        data = pathlib.Path(job["path"]).read_bytes()
    except OSError as error:
        return {"status": "unreadable", "message": error.strerror or str(error)}
    sha256 = hashlib.sha256(data).hexdigest()
    key = result_key(sha256, job["options"], trimtess.__version__)
    watch.lap("hash")
    identity = {"sha256": sha256, "key": key}
    store = Store(job["out"])
    stored = store.find(key)
    if stored is not None:
        return {**stored, **identity, "reused": True}
    try:
        with store.writing(job["run"]) as scratch:
            result = make(data, Options.from_canonical(job["options"]), job, scratch, watch)
            if result["status"] in STORED:
                folder = str(store.folder(key).relative_to(store.out))
                outputs = [describe(path, folder) for path in sorted(scratch.iterdir())]
                watch.lap("write")
                costs = {"seconds": watch.seconds, "peak_memory": peak_memory(), "cores": job["workers"]}
                result = store.publish(scratch, key, {**result, **costs, "outputs": outputs})
            return {**result, **identity, "reused": False}
    except trimtess.NoAdapterError as error:
        return {**identity, "status": "no-adapter", "message": one_line(error)}
    except OSError as error:
        status = "full" if error.errno in FULL else "crashed"
        return {**identity, "status": status, "message": f"{type(error).__name__}: {error.strerror or error}"}


#: Errors that the file and the options cause, the same in every run. Others may be the machine's.
REFUSED = (trimtess.ReadError, trimtess.RoundingError, trimtess.RangeError)


def make(data: bytes, options: Options, job: Json, scratch: pathlib.Path, watch: Stopwatch) -> Json:
    """Reads, prepares, tessellates, checks and writes. Returns a result without outputs and costs."""
    try:
        return {"message": None, **measure(data, options, job, scratch, watch)}
    except trimtess.LimitError as error:
        return {"status": "limit", "message": one_line(error)}
    except REFUSED as error:
        # The outputs of a file are all there or none is.
        for path in scratch.iterdir():
            path.unlink()
        # The folder has another name each time.
        return {"status": "refused", "message": one_line(error).replace(f"{scratch}/", "")}


def measure(data: bytes, options: Options, job: Json, scratch: pathlib.Path, watch: Stopwatch) -> Json:
    """Makes and writes the mesh. Returns what the catalogue says of it."""
    workers: int = job["workers"]
    model = trimtess.read(data, max_memory=job["max_memory"], supplemental=options.supplemental, workers=workers)
    watch.lap("read")
    prepared = model.prepare(workers=workers)
    watch.lap("prepare")
    mesh = prepared.tessellate(**options.tolerance(), workers=workers)
    watch.lap("tessellate")
    check = mesh.check()
    watch.lap("check")
    statuses = {mesh.status, *write(mesh, prepared, options, workers, scratch)}
    watch.lap("write")
    codes = [diagnostic.code for diagnostic in mesh.diagnostics] + ["check-failed"] * len(check.faults)
    return {
        "status": "partial" if 3 in statuses or check.faults else "whole",
        "diagnostics": dict(sorted(collections.Counter(codes).items())),
        "parts": len(mesh.parts),
        "faces": mesh.face_count,
        "triangles": check.triangles,
        "area_mm2": check.area,
        "volume_mm3": check.volume,
        "closed": check.closed,
    }


def write(
    mesh: "trimtess.Mesh", prepared: "trimtess.Prepared", options: Options, workers: int, scratch: pathlib.Path
) -> Iterator[int]:
    """Writes every format to its file. Yields the statuses of meshes, which are 3 if faces were rounded away."""
    for name in options.formats:
        if name == "png":
            # Imported here: a run without pictures needs it not.
            from PIL import Image

            Image.fromarray(prepared.render(*options.size, workers=workers)).save(scratch / "picture.png")
        else:
            yield mesh.save(scratch / f"mesh.{name}", recenter=options.recenter).status


def one_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__


def peak_memory() -> Optional[int]:
    """Peak resident memory of this process, bytes. `None` where /proc is missing."""
    with open("/proc/self/status") as status:
        for line in status:
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024
    return None


#: The function that a server calls for a job.
Convert = Callable[[Json], Json]
