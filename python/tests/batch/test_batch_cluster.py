"""Runs on a Ray cluster that is there already: also those that need many runs, because a Ray of its own takes each of
them ten seconds to start and to end."""

import os
import pathlib
import secrets
import socket
import subprocess
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

import trimtess
from trimtess.batch import cluster as clusters
from trimtess.batch import drive, task
from trimtess.batch.catalogue import read
from trimtess.batch.drive import Driver
from trimtess.batch.errors import BatchError
from trimtess.batch.plan import Bundle, Work
from trimtess.batch.sources import Source

from . import chaos, variations
from .running import batch


def unused_port() -> int:
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        return unused.getsockname()[1]


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """Ports of a cluster of one node on this machine, for drivers in it and for clients."""
    port, clients = unused_port(), unused_port()
    environment = {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": secrets.token_hex(32), "RAY_USAGE_STATS_ENABLED": "0"}
    # Ray's proxy for clients forks while threads of its gRPC run. gRPC's handlers of forks then crash some children
    # before they become servers (ray-project/ray#63202).
    started = {**os.environ, **environment, "GRPC_ENABLE_FORK_SUPPORT": "0"}
    # Sockets are in the folder: its path must be short.
    folder = pathlib.Path("/tmp") / f"b{secrets.token_hex(3)}"
    command = [sys.executable, "-m", "ray.scripts.scripts", "start", "--head", "--block", "--num-cpus=1"]
    command += [f"--port={port}", f"--ray-client-server-port={clients}", "--object-store-memory=80000000"]
    command += ["--include-dashboard=false", f"--temp-dir={folder}"]
    command += ["--node-ip-address=127.0.0.1", "--min-worker-port=0", "--max-worker-port=0"]
    head = subprocess.Popen(command, env=started, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    until = time.monotonic() + 60
    while not (answers(port) and answers(clients)):
        assert head.poll() is None and time.monotonic() < until
        time.sleep(0.2)
    with pytest.MonkeyPatch.context() as patch:
        for name, value in environment.items():
            patch.setenv(name, value)
        yield {"host": f"127.0.0.1:{port}", "client": f"ray://127.0.0.1:{clients}"}
    head.terminate()
    head.wait(timeout=30)
    subprocess.run(["rm", "-rf", str(folder)], check=True)


def answers(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


@pytest.mark.parametrize("way", ["client", "host"])
def test_files_are_converted_on_a_cluster(cluster, data, tmp_path, way):
    done = batch("convert", data, "--out", tmp_path / "out", "-q", "--address", cluster[way])
    assert done.returncode in (0, 3), done.stderr
    assert sorted(os.listdir(tmp_path / "out")) == ["catalogue", "objects"]
    assert {row["status"] for row in read(tmp_path / "out")[1].to_pylist()} <= {"whole", "partial"}


def test_limits_cost_rows_that_can_be_tried_again(cluster, data, tmp_path):
    """Files over their memory, then over their time, are tried again with more of both."""
    folder = tmp_path / "in"
    variations.write([data / "nist_ctc05.step"], folder, 6, seed=3, broken=0.0)
    out = tmp_path / "out"
    options = ["--address", cluster["host"], "--retries", 1]
    done = batch("convert", folder, "--out", out, "--max-memory", 1, *options)
    assert done.returncode == 3
    assert {(row["status"], row["attempts"]) for row in chaos.rows(out)} == {("limit", 1)}
    done = batch("convert", folder, "--out", out, "--retry-failed", "--time-limit", 0.001, *options)
    assert {(row["status"], row["attempts"]) for row in chaos.rows(out)} == {("timeout", 2)}
    done = batch("convert", folder, "--out", out, "--retry-failed", *options)
    assert done.returncode in (0, 3) and len(chaos.rows(out)) == 6
    assert {row["status"] for row in chaos.rows(out)} <= {"whole", "partial"}


def test_pictures_appear_with_meshes(cluster, prepared, data, tmp_path):
    try:
        expected = prepared.render(320, 240)
    except trimtess.NoAdapterError as error:
        pytest.skip(str(error))
    options = ["--formats", "glb,png", "--size", "320x240", "--address", cluster["host"], "-q"]
    done = batch("convert", data / "red_cube_blue_cylinder.step", "--out", tmp_path / "out", *options)
    assert done.returncode == 0, done.stderr
    [row] = read(tmp_path / "out")[1].to_pylist()
    assert [output["format"] for output in row["outputs"]] == ["glb", "png"] and row["attempts"] == 1
    with Image.open(tmp_path / "out" / row["outputs"][1]["path"]) as picture:
        assert np.array_equal(np.asarray(picture), expected)


def test_a_catalogue_of_other_options_is_one_clear_line(cluster, data, tmp_path):
    cube = data / "red_cube_blue_cylinder.step"
    assert batch("convert", cube, "--out", tmp_path / "out", "--address", cluster["host"]).returncode == 0
    done = batch("convert", cube, "--out", tmp_path / "out", "--angle", 5)
    assert done.returncode == 1 and done.stderr.count("\n") == 1
    assert "catalogue of other options: angle 20.0 (now 5.0)" in done.stderr


def test_a_worker_with_another_version_stops_the_run(tmp_path):
    bundle = {"version": "0.0.0-other", "paths": [], "job": {"out": str(tmp_path), "run": "run"}}
    with pytest.raises(BatchError, match="has trimtess .*, the driver has 0.0.0-other"):
        task.run_bundle(bundle)


def test_a_worker_that_does_not_see_the_output_folder_stops_the_run(tmp_path):
    bundle = {"version": task.trimtess.__version__, "paths": [], "job": {"out": str(tmp_path / "gone"), "run": "run"}}
    with pytest.raises(BatchError, match="does not see .*: --out must be a shared folder"):
        task.run_bundle(bundle)


def test_a_run_gives_up_once_no_node_is_left():
    cores = {"CPU": 4.0}
    driver = SimpleNamespace(ray=SimpleNamespace(cluster_resources=lambda: cores), seen=time.monotonic() - 1000.0)
    assert Driver.count_slots(driver) == 4
    driver.seen = time.monotonic() - drive.LOST_SECONDS / 2
    cores.clear()
    assert Driver.count_slots(driver) == 1
    driver.seen = time.monotonic() - drive.LOST_SECONDS - 1
    with pytest.raises(BatchError, match="Ray lost all of its nodes; run the same command again to continue"):
        Driver.count_slots(driver)


def test_a_run_gives_up_once_workers_are_lost_at_no_file():
    plan = SimpleNamespace(lost=lambda bundle, at: [])
    driver = SimpleNamespace(lost_idle=0, plan=plan)
    for _ in range(2):
        for _ in range(drive.MOST_LOST_IDLE):
            Driver.lose(driver, None, None, "it died")
        Driver.lose(driver, None, 0, "it died")
    for _ in range(drive.MOST_LOST_IDLE):
        Driver.lose(driver, None, None, "it died")
    with pytest.raises(BatchError, match="101 workers in a row were lost while they were at no file: it died"):
        Driver.lose(driver, None, None, "it died")


def test_a_retry_goes_to_another_node():
    nodes = [{"NodeID": f"{number:056}", "Alive": number != 2} for number in range(3)]
    driver = SimpleNamespace(ray=SimpleNamespace(nodes=lambda: nodes))
    work = Work(Source("/a.step", 1, ""))
    bundle = Bundle([work], 1, 1, 1.0)
    assert Driver.elsewhere(driver, bundle) == {}
    work.node = nodes[0]["NodeID"]
    strategy = Driver.elsewhere(driver, bundle)["scheduling_strategy"]
    assert strategy.node_id == nodes[1]["NodeID"] and strategy.soft
    nodes[1]["Alive"] = False
    assert Driver.elsewhere(driver, bundle) == {}


@pytest.mark.skipif(not os.path.exists("/proc"), reason="processes are found in /proc")
def test_a_folder_is_removed_once_no_worker_can_make_it_anew(tmp_path):
    """As a worker does that was starting when its driver was killed."""
    folder = tmp_path / f"{clusters.FOLDER}of-a-killed-run"
    folder.mkdir()
    late = f"import os, time; time.sleep(1); os.makedirs({str(folder / 'logs')!r}, exist_ok=True)"
    words = [sys.executable, "-c", late, "/x/ray/_private/workers/default_worker.py", f"--temp-dir={folder}"]
    with subprocess.Popen(words) as worker:
        while not clusters.has_workers(str(folder)):
            assert worker.poll() is None
            time.sleep(0.01)
        assert not clusters.has_workers(str(folder) + "-other")
        clusters.remove_folders([str(folder)])
        assert worker.wait() == 0 and not folder.exists()
