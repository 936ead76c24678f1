"""The catalogue: a folder of Parquet segments with one row per source, appended by one run at a time.

    catalogue/_catalogue.json      layout, version of trimtess and options that its rows belong to
    catalogue/_lock                locked by the run that writes; says which that is
    catalogue/rows-00000001.parquet, …

A segment is written under a hidden name, flushed to the disk and renamed, so it is whole or absent. Appending never
touches what is there. `remove`, for files that changed, replaces one segment after the other in the same way. So a
path has at most one row at any moment, and readers need nothing but Parquet: pyarrow takes names that start
with `_` or `.` for no data.
"""

from __future__ import annotations

import fcntl
import json
import os
import pathlib
from typing import Collection, Dict, Iterable, Iterator, List, Optional

import pyarrow
import pyarrow.parquet

import trimtess

from .errors import FULL, BatchError, DiskFull
from .options import LAYOUT, Json

#: Stages of a file, in order: columns `seconds_…`.
STAGES = ("fetch", "hash", "read", "prepare", "tessellate", "check", "write")

#: All that may become of a file. docs/batch.md explains each.
STATUSES = ("whole", "partial", "refused", "limit", "timeout", "crashed", "unreadable", "lost")

TEXT, COUNT, NUMBER = pyarrow.string(), pyarrow.int64(), pyarrow.float64()
OUTPUT = pyarrow.struct([("format", TEXT), ("path", TEXT), ("bytes", COUNT), ("sha256", TEXT)])
TIME = pyarrow.timestamp("us", tz="UTC")

COLUMNS = [
    ("path", TEXT),
    ("size", COUNT),
    ("stamp", TEXT),
    ("sha256", TEXT),
    ("key", TEXT),
    ("status", TEXT),
    ("message", TEXT),
    ("outputs", pyarrow.list_(OUTPUT)),
    ("diagnostics", pyarrow.map_(TEXT, COUNT)),
    ("parts", COUNT),
    ("faces", COUNT),
    ("triangles", COUNT),
    ("area_mm2", NUMBER),
    ("volume_mm3", NUMBER),
    ("closed", pyarrow.bool_()),
    *((f"seconds_{stage}", NUMBER) for stage in STAGES),
    ("seconds", NUMBER),
    ("peak_memory", COUNT),
    ("memory_limit", COUNT),
    ("cores", COUNT),
    ("attempts", COUNT),
    ("reused", pyarrow.bool_()),
    ("host", TEXT),
    ("started", TIME),
    ("finished", TIME),
    ("run", TEXT),
]

SCHEMA = pyarrow.schema([pyarrow.field(name, kind, nullable=name not in ("path", "status")) for name, kind in COLUMNS])

HEAD, LOCK = "_catalogue.json", "_lock"


class Catalogue:
    """The catalogue of an output folder. `with Catalogue.open(…)` holds its lock."""

    def __init__(self, folder: pathlib.Path, lock: int) -> None:
        self.folder = folder
        self._lock = lock
        #: What the lock says of a run that was killed; empty after one that ended.
        self.killed = holder_of(lock)
        self._next = 1 + max((number(path) for path in segments(folder)), default=0)

    @classmethod
    def open(cls, out: pathlib.Path, options: Json) -> "Catalogue":
        """Opens or creates the catalogue in an output folder for a run with these options.

        Raises `BatchError` if another run writes to it, or if it belongs to another version or other options.
        """
        folder = out / "catalogue"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            lock = take_lock(folder)
            for path in folder.glob(".*.part"):
                path.unlink()
            head = {"layout": LAYOUT, "version": trimtess.__version__, "options": options}
            if (folder / HEAD).exists():
                check_head(folder, head)
            else:
                write_whole(folder / HEAD, json.dumps(head, indent=1, sort_keys=True).encode())
        except OSError as error:
            raise failure(folder, error) from error
        return cls(folder, lock)

    def __enter__(self) -> "Catalogue":
        return self

    def __exit__(self, *_: object) -> None:
        self.note({})
        os.close(self._lock)

    def note(self, what: Json) -> None:
        """Writes what the lock says of its holder: `pid`, `host`, and what to clean up if it is killed.

        A run that is killed in here leaves the new note, with the end of the old one after it, or the old one."""
        text = json.dumps(what).encode()
        os.pwrite(self._lock, text, 0)
        os.ftruncate(self._lock, len(text))

    def append(self, rows: List[Json]) -> None:
        """Adds a segment. Raises `DiskFull` and leaves the catalogue as it was if there is no room."""
        if rows:
            path = self.folder / f"rows-{self._next:08}.parquet"
            self._write(path, pyarrow.Table.from_pylist(rows, schema=SCHEMA))
            self._next += 1

    def remove(self, paths: Collection[str]) -> None:
        """Removes the rows of these paths."""
        wanted = pyarrow.array(sorted(paths), TEXT)
        for segment in segments(self.folder):
            table = pyarrow.parquet.read_table(segment, schema=SCHEMA)
            kept = table.filter(pyarrow.compute.invert(pyarrow.compute.is_in(table["path"], value_set=wanted)))
            if not len(kept):
                segment.unlink()
            elif len(kept) < len(table):
                self._write(segment, kept)

    def _write(self, path: pathlib.Path, table: pyarrow.Table) -> None:
        sink = pyarrow.BufferOutputStream()
        pyarrow.parquet.write_table(table, sink, compression="zstd")
        try:
            write_whole(path, sink.getvalue())
        except OSError as error:
            raise failure(self.folder, error) from error

    def known(self) -> Dict[str, Json]:
        """Size, stamp and status of each path that has a row."""
        columns = ["path", "size", "stamp", "status"]
        return {row["path"]: row for batch in tables(self.folder, columns) for row in batch.to_pylist()}


def read(place: "os.PathLike[str] | str") -> "tuple[Json, pyarrow.Table]":
    """Head and rows of a catalogue: of its folder, or of the output folder that has it. Needs no lock.

    Raises `BatchError` if the folder has no catalogue, or one of another layout.
    """
    folder = pathlib.Path(place)
    if (folder / "catalogue" / HEAD).exists():
        folder = folder / "catalogue"
    try:
        head = json.loads((folder / HEAD).read_text())
    except (FileNotFoundError, NotADirectoryError):
        raise BatchError(f"{place}: no catalogue") from None
    except ValueError as error:
        raise BatchError(f"{folder / HEAD}: {error}") from error
    if head.get("layout") != LAYOUT:
        raise BatchError(f"{folder}: catalogue of layout {head.get('layout')}, this version reads layout {LAYOUT}")
    return head, pyarrow.concat_tables(tables(folder)) if segments(folder) else SCHEMA.empty_table()


def segments(folder: pathlib.Path) -> List[pathlib.Path]:
    return sorted(folder.glob("rows-*.parquet"))


def number(segment: pathlib.Path) -> int:
    return int(segment.stem.partition("-")[2])


def tables(folder: pathlib.Path, columns: Optional[List[str]] = None) -> Iterator[pyarrow.Table]:
    """The segments, one after the other. One that a run replaces meanwhile is read as it was or as it is."""
    for segment in segments(folder):
        try:
            yield pyarrow.parquet.read_table(segment, columns=columns, schema=SCHEMA)
        except FileNotFoundError:
            continue
        except (OSError, pyarrow.ArrowInvalid) as error:
            raise BatchError(f"{segment}: {' '.join(str(error).split())}") from error


def take_lock(folder: pathlib.Path) -> int:
    """Locks a catalogue for this process. The system frees the lock when the process ends, however it ends."""
    lock = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        holder = holder_of(lock)
        os.close(lock)
        who = f" (process {holder['pid']} on {holder['host']})" if "pid" in holder else ""
        raise BatchError(f"{folder}: in use by another run{who}") from None
    return lock


def holder_of(lock: int) -> Json:
    """What the lock says of the run that holds it, or that held it and was killed."""
    try:
        note: Json = json.JSONDecoder().raw_decode(os.pread(lock, 1 << 16, 0).decode() or "{}")[0]
        return note
    except ValueError:
        return {}


def check_head(folder: pathlib.Path, wanted: Json) -> None:
    """Raises if a catalogue's rows cannot go with those of this run."""
    try:
        head = json.loads((folder / HEAD).read_text())
    except ValueError as error:
        raise BatchError(f"{folder / HEAD}: {error}") from error
    if head.get("layout") != wanted["layout"]:
        raise BatchError(
            f"{folder}: catalogue of layout {head.get('layout')}, this version writes layout {LAYOUT}; "
            "convert into another folder"
        )
    if head["version"] != wanted["version"]:
        raise BatchError(
            f"{folder}: catalogue of trimtess {head['version']}, this is {wanted['version']}; "
            "convert into another folder"
        )
    was, now = head["options"], wanted["options"]
    other = [f"{name} {was.get(name)} (now {now.get(name)})" for name in now if was.get(name) != now.get(name)]
    if other:
        raise BatchError(f"{folder}: catalogue of other options: {', '.join(other)}; convert into another folder")


def write_whole(path: pathlib.Path, data: "bytes | pyarrow.Buffer") -> None:
    """Writes a file that is there with all of its data, after a power failure too, or as it was before."""
    part = path.with_name(f".{path.name}.part")
    try:
        with open(part, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.rename(part, path)
        folder = os.open(path.parent, os.O_RDONLY)
        os.fsync(folder)
        os.close(folder)
    except OSError:
        part.unlink(missing_ok=True)
        raise


def failure(folder: pathlib.Path, error: OSError) -> BatchError:
    reason = error.strerror or str(error)
    return DiskFull(str(folder), reason) if error.errno in FULL else BatchError(f"{folder}: {reason}")


def row(source_path: str, size: Optional[int], stamp: str, outcome: Json, extra: Json) -> Json:
    """The row of a source. `outcome`: from `task.run_bundle`. `extra`: attempts, host, run, memory_limit."""
    seconds = outcome.get("seconds", {})
    names: Iterable[str] = ("sha256", "key", "status", "message", "outputs", "parts", "faces", "triangles", "area_mm2")
    names = (*names, "volume_mm3", "closed", "peak_memory", "cores", "reused")
    return {
        "path": source_path,
        "size": size,
        "stamp": stamp,
        **{name: outcome.get(name) for name in names},
        "diagnostics": list(outcome.get("diagnostics", {}).items()),
        **{f"seconds_{stage}": seconds.get(stage) for stage in STAGES},
        "seconds": outcome.get("finished", 0.0) - outcome.get("started", 0.0) if "started" in outcome else None,
        "started": micros(outcome.get("started")),
        "finished": micros(outcome.get("finished")),
        **extra,
    }


def micros(seconds: Optional[float]) -> Optional[int]:
    return None if seconds is None else round(seconds * 1e6)
