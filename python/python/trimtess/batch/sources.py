"""Arguments -> sources: files, folders, globs, manifests and URLs become one list of files with sizes."""

from __future__ import annotations

import dataclasses
import datetime
import glob
import os
import pathlib
from typing import Any, Dict, Iterable, List, Optional, Tuple

import fsspec

from .errors import BatchError
from .options import Json

#: Endings of the files that folders are searched for. A file that is named is taken whatever its ending.
ENDINGS = (".stp", ".step", ".p21")

#: Endings of manifests.
MANIFESTS = (".csv", ".parquet")

#: Columns of a manifest that hold paths or URLs; the first one that is there counts.
COLUMNS = ("path", "url", "uri", "file")


@dataclasses.dataclass(frozen=True)
class Source:
    """One input file."""

    #: Absolute path, or URL.
    path: str
    #: Bytes; `None` if the file cannot be seen.
    size: Optional[int]
    #: Changes when the file does: time of change, or the tag of an object store.
    stamp: str


def find(arguments: Iterable[str]) -> List[Source]:
    """All sources that the arguments name, without repetitions, in the order of the arguments.

    Raises `BatchError` for an argument that names nothing. A file that a manifest names but that is not there is a
    source without a size: it costs its own row.
    """
    found: Dict[str, Source] = {}
    for argument in arguments:
        for source in expand(argument):
            found.setdefault(source.path, source)
    if not found:
        raise BatchError("no files to convert")
    return list(found.values())


def expand(argument: str) -> List[Source]:
    """The sources of one argument."""
    system, name = open_system(argument)
    try:
        if glob.has_magic(argument) and not (is_local(system) and os.path.exists(name)):
            every = (followed(system, info) for info in system.glob(name, detail=True).values())
            sources = [of(system, info) for info in every if info and info["type"] == "file"]
            what = "matches no file"
        elif (info := info_of(system, name)) is None:
            raise BatchError(f"{argument}: no such file or folder")
        elif info["type"] == "directory":
            named = (info for info in system.find(name, detail=True).values() if info["name"].lower().endswith(ENDINGS))
            every = (followed(system, info) for info in named)
            sources = [of(system, info) for info in every if info and info["type"] == "file"]
            what = f"has no file that ends in {', '.join(ENDINGS)}"
        elif name.lower().endswith(MANIFESTS):
            sources = manifest(system, name, argument)
            what = "lists no file"
        else:
            return [of(system, info)]
    except BatchError:
        raise
    except Exception as error:  # Each storage has exceptions of its own.
        raise BatchError(f"{argument}: {' '.join(str(error).split()) or type(error).__name__}") from error
    if not sources:
        raise BatchError(f"{argument}: {what}")
    return sorted(sources, key=lambda source: source.path)


def open_system(argument: str) -> Tuple[Any, str]:
    """The file system of a path or URL, and the name in it."""
    try:
        system, name = fsspec.core.url_to_fs(argument)
        return system, name
    except (ValueError, ImportError) as error:
        raise BatchError(f"{argument}: {' '.join(str(error).split())}") from error


def info_of(system: Any, name: str) -> Optional[Json]:
    try:
        info: Json = system.info(name)
        return info
    except FileNotFoundError:
        return None


def is_local(system: Any) -> bool:
    return "file" in ([system.protocol] if isinstance(system.protocol, str) else system.protocol)


def followed(system: Any, info: Json) -> Optional[Json]:
    """A file system's entry. A link has its own name, and all else of its target; `None` without a target."""
    if not info.get("islink"):
        return info
    target = info_of(system, info["name"])
    return target and {**target, "name": info["name"]}


def of(system: Any, info: Json) -> Source:
    """The source that a file system's entry describes."""
    path = info["name"] if is_local(system) else system.unstrip_protocol(info["name"])
    stamp = next((info[key] for key in ("ETag", "etag", "mtime", "LastModified", "updated") if key in info), "")
    if isinstance(stamp, datetime.datetime):
        stamp = stamp.isoformat()
    return Source(path, info["size"], str(stamp))


def manifest(system: Any, name: str, argument: str) -> List[Source]:
    """The sources that a CSV file (with a header) or a Parquet file lists. Relative paths start at its folder."""
    import pyarrow.csv
    import pyarrow.parquet

    with system.open(name, "rb") as file:
        if name.lower().endswith(".csv"):
            # A path such as 0012 is no number.
            texts = pyarrow.csv.ConvertOptions(column_types={column: pyarrow.string() for column in COLUMNS})
            table = pyarrow.csv.read_csv(file, convert_options=texts)
        else:
            table = pyarrow.parquet.read_table(file)
    column = next((column for column in COLUMNS if column in table.column_names), None)
    if column is None:
        raise BatchError(f"{argument}: has no column named {', '.join(COLUMNS[:-1])} or {COLUMNS[-1]}")
    folder = argument.rpartition("/")[0] if "://" in argument else str(pathlib.Path(name).parent)
    paths = [str(path) for path in table.column(column).to_pylist() if path]
    return [listed(path if "://" in path or os.path.isabs(path) else f"{folder}/{path}") for path in paths]


def listed(path: str) -> Source:
    """The source at a path of a manifest."""
    try:
        system, name = open_system(path)
        info = info_of(system, name)
    except Exception:  # Told by the worker that fails to open it, in its row.
        info = None
    if info is None or info["type"] != "file":
        return Source(path if "://" in path else os.path.abspath(path), None, "")
    return of(system, info)
