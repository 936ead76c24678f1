"""Ray: starts one on this machine, or connects to a cluster, and says what it has."""

from __future__ import annotations

import contextlib
import dataclasses
import logging
import os
import pathlib
import secrets
import socket
import tempfile
import time
from typing import Any, Iterable, Iterator, Optional

from .errors import BatchError, UsageError
from .options import Json
from .store import remove_tree

#: Ray's least. Results are small dictionaries, so more would only take memory.
OBJECT_STORE = 80 << 20

#: Seconds to wait for a cluster to answer.
CONNECT_SECONDS = 5.0

#: Seconds to wait for the processes of a Ray whose driver was killed.
END_SECONDS = 10.0

#: Start of the names of folders that an embedded Ray writes to.
FOLDER = "trimtess-ray-"


@dataclasses.dataclass
class Cluster:
    """A cluster that answers."""

    #: Cores of all nodes, and of the largest.
    cores: int
    cores_of_largest: int
    #: Bytes that tasks may ask for on the node that has most.
    memory_of_largest: int


@contextlib.contextmanager
def connected(address: Optional[str], cores: Optional[int], folder: Optional[str]) -> Iterator[Cluster]:
    """Ray, for the length of a block. `address` `None`: one of our own, on `cores` cores, that writes to `folder`, which
    is made here.

    Raises `BatchError` if the address does not answer, or Ray is not installed.
    """
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    if address is None:
        # A token of its own: nobody else can give it work. Ray would write one to the home folder. It reads these
        # variables when it is imported.
        os.environ.update(RAY_AUTH_MODE="token", RAY_AUTH_TOKEN=secrets.token_hex(32))
        # Ray would start workers before the first task, and wait for ever if one dies then (ray-project/ray#40131).
        os.environ["RAY_prestart_worker_first_driver"] = "0"
        # Ray would connect to the cluster that this variable names.
        os.environ.pop("RAY_ADDRESS", None)
    try:
        import ray
    except ImportError as error:
        raise BatchError(f"Ray is not installed ({error}): pip install 'trimtess[batch]'") from error
    quiet = {"log_to_driver": False, "logging_level": logging.CRITICAL, "configure_logging": False}
    # Ray prints a paragraph for each worker that dies. That is told by rows here.
    silence = contextlib.ExitStack()
    silence.enter_context(contextlib.redirect_stdout(silence.enter_context(open(os.devnull, "w"))))
    try:
        if address is None:
            start_embedded(ray, cores, folder, quiet)
        else:
            check_answers(address)
            connect(ray, address, quiet)
        yield survey(ray)
    finally:
        if ray.is_initialized():
            ray.shutdown()
        silence.close()
        remove_folders([folder] if folder else [])


def start_embedded(ray: Any, cores: Optional[int], folder: Optional[str], quiet: Json) -> None:
    """Starts Ray on this machine."""
    try:
        if folder is not None:
            os.mkdir(folder, 0o700)
        ray.init(
            num_cpus=cores or usable_cores(),
            include_dashboard=False,
            object_store_memory=OBJECT_STORE,
            _temp_dir=folder,
            **quiet,
        )
    except Exception as error:  # Ray raises many kinds here.
        raise BatchError(f"Ray does not start on this machine: {one_line(error)}") from error


def connect(ray: Any, address: str, quiet: Json) -> None:
    """Connects to a cluster."""
    if address.startswith("ray://"):
        quiet = {"logging_level": logging.CRITICAL}
    try:
        ray.init(address=address, **quiet)
    except ImportError as error:
        raise BatchError(f"{address}: {one_line(error)}; pip install 'ray[client]'") from error
    except Exception as error:  # Ray raises many kinds here.
        raise BatchError(f"{address}: cannot connect: {one_line(error)}") from error


def check_answers(address: str) -> None:
    """Raises unless something listens at HOST:PORT or ray://HOST:PORT. Ray itself would try for minutes."""
    if address == "auto":
        return
    host, _, port = address.rpartition("://")[2].rpartition(":")
    if not host or not port.isdigit():
        raise UsageError(f"--address {address}: not ray://HOST:PORT, HOST:PORT or auto")
    try:
        socket.create_connection((host.strip("[]"), int(port)), CONNECT_SECONDS).close()
    except (OSError, OverflowError) as error:
        raise BatchError(f"{address}: {getattr(error, 'strerror', None) or error}") from error


def survey(ray: Any) -> Cluster:
    """What the cluster has, and its node with the most memory."""
    nodes = [node["Resources"] for node in ray.nodes() if node["Alive"]]
    sizes = [(int(node.get("memory", 0)), int(node["CPU"])) for node in nodes if int(node.get("CPU", 0))]
    if not sizes:
        raise BatchError("the cluster has no cores")
    # Of one node: no other can run a file that asks for both.
    memory, cores = max(sizes)
    return Cluster(sum(cores for _, cores in sizes), cores, memory)


def new_folder() -> str:
    """Names a folder for an embedded Ray, and does not make it: a run that is killed at any moment has noted the name of
    each folder that it made. The path is short: sockets are in the folder."""
    return os.path.join(tempfile.gettempdir(), FOLDER + secrets.token_urlsafe(6))


def remove_folders(folders: Iterable[str]) -> None:
    """Removes what embedded Rays wrote. `folders`: as `new_folder` named them.

    If a driver is killed while one of its workers starts, that worker still creates the folder. So this first waits until such
    workers have ended, for at most `END_SECONDS`. Agents of Ray may run for two more minutes. They write no new files."""
    for folder in folders:
        if pathlib.Path(folder).name.startswith(FOLDER):
            until = time.monotonic() + END_SECONDS
            while has_workers(folder) and time.monotonic() < until:
                time.sleep(0.05)
            remove_tree(folder)


def has_workers(folder: str) -> bool:
    """Whether an embedded Ray that writes to `folder` has workers that start, or its process that starts them. `False` where
    the system has no /proc."""
    for path in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = path.read_bytes().split(b"\0")
        except OSError:  # It has ended.
            continue
        is_of_ray = words[0].endswith(b"/raylet") or any(b"/ray/_private/workers/" in word for word in words)
        if is_of_ray and any(os.fsencode(folder) in word for word in words):
            return True
    return False


def usable_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))


def one_line(error: BaseException) -> str:
    """The first line of a message; the last one of a traceback."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()] or [type(error).__name__]
    return lines[-1] if any(line.startswith("Traceback") for line in lines) else lines[0]
