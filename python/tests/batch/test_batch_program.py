"""The program as a user runs it: what it prints, and its exit status. Each starts a real Ray on this machine."""

import os
import pathlib
import shutil
import signal
import socket
import subprocess
import time

import pytest

from trimtess.batch.catalogue import read

from . import chaos
from .running import batch, command


def status_of(out: pathlib.Path):
    return {pathlib.Path(row["path"]).name: row["status"] for row in read(out)[1].to_pylist()}


def test_files_are_converted_once_and_reported(data, tmp_path):
    inputs, out = tmp_path / "in", tmp_path / "out"
    inputs.mkdir()
    shutil.copy(data / "nist_ctc05.step", inputs)
    shutil.copy(data / "red_cube_blue_cylinder.step", inputs)
    (inputs / "no.step").write_text("no STEP")
    before = chaos.ray_folders()
    first = batch("convert", inputs, "--out", out, "--formats", "glb,stl", "--cores", 2)
    assert first.returncode == 3, first.stderr
    assert first.stdout.startswith("3 of 3 files converted in ") and first.stdout.endswith("1 refused\n")
    assert status_of(out)["no.step"] == "refused"
    rows = {pathlib.Path(row["path"]).name: row for row in read(out)[1].to_pylist()}
    cube = rows["red_cube_blue_cylinder.step"]
    assert cube["status"] == "whole" and cube["closed"] and cube["attempts"] == 1
    assert [output["format"] for output in cube["outputs"]] == ["glb", "stl"]
    assert 0 < cube["peak_memory"] < cube["memory_limit"] and cube["seconds"] > 0

    # Again: every row is there. One file changes: its row is replaced.
    again = batch("convert", inputs, "--out", out, "--formats", "glb,stl")
    assert again.returncode == 3 and "0 of 3 files converted, 3 had their row before" in again.stdout
    shutil.copy(data / "red_cube_blue_cylinder.step", inputs / "no.step")
    changed = batch("convert", inputs, "--out", out, "--formats", "glb,stl", "--cores", 1)
    assert "1 of 3 files converted" in changed.stdout
    rows = {pathlib.Path(row["path"]).name: row for row in read(out)[1].to_pylist()}
    assert len(rows) == 3 and rows["no.step"]["reused"] and rows["no.step"]["outputs"] == cube["outputs"]
    assert chaos.leftovers(out, before) == []

    report = batch("report", out, "--plot", tmp_path / "plot.png")
    assert report.returncode == 0 and "3 files: " in report.stdout and "slowest:" in report.stdout
    assert (tmp_path / "plot.png").read_bytes().startswith(b"\x89PNG")


def test_objects_of_a_store_are_converted(bucket, data, tmp_path):
    bucket.put(str(data / "red_cube_blue_cylinder.step"), "parts/cube.step")
    bucket.pipe("parts/no.step", b"no STEP")
    done = batch("convert", "s3://parts", "--out", tmp_path / "out", "-q", "--cores", 1)
    assert (done.returncode, done.stdout, done.stderr) == (3, "", "")
    rows = read(tmp_path / "out")[1].to_pylist()
    assert {row["path"]: row["status"] for row in rows} == {
        "s3://parts/cube.step": "whole",
        "s3://parts/no.step": "refused",
    }
    assert all(row["seconds_fetch"] > 0 for row in rows)


def test_a_machine_that_cannot_draw_is_one_clear_line(data, tmp_path):
    # Not on this system.
    undrawable = {**os.environ, "WGPU_BACKEND": "dx12"}
    done = batch("convert", data, "--out", tmp_path / "out", "--formats", "png", "--cores", 1, "-q", env=undrawable)
    assert done.returncode == 1 and done.stderr.count("\n") == 1
    assert f"worker {socket.gethostname()} cannot draw pictures: " in done.stderr


def test_an_interrupted_run_keeps_what_is_done(data, tmp_path):
    inputs, out = tmp_path / "in", tmp_path / "out"
    inputs.mkdir()
    for number in range(60):
        text = (data / "nist_ctc05.step").read_bytes()
        (inputs / f"{number}.step").write_bytes(text + b"/* %d */\n" % number)
    before = chaos.ray_folders()
    running = subprocess.Popen(command("convert", inputs, "--out", out, "--cores", 1), stderr=subprocess.PIPE)
    while len(list(out.glob("objects/*/*"))) < 3:
        assert running.poll() is None
        time.sleep(0.02)
    running.send_signal(signal.SIGINT)
    _, told = running.communicate(timeout=60)
    assert running.returncode == 130
    assert told.decode().splitlines()[-1] == "trimtess-batch: stopped; run the same command again to continue"
    made = {path.name: path.stat().st_mtime_ns for path in out.glob("objects/*/*")}
    assert chaos.leftovers(out, before) == [] and 3 <= len(made) < 60
    done = batch("convert", inputs, "--out", out, "--cores", 2)
    assert done.returncode in (0, 3) and len(status_of(out)) == 60
    assert {name: (out / "objects" / name[:2] / name).stat().st_mtime_ns for name in made} == made


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["convert", "{here}/gone.step"], 1, "{here}/gone.step: no such file or folder"),
        (["convert", "{here}/empty"], 1, "{here}/empty: has no file that ends in .stp, .step, .p21"),
        (["convert", "{cube}", "--address", "127.0.0.1:{port}"], 1, "127.0.0.1:{port}: Connection refused"),
        (["convert", "{cube}", "--address", "ray://127.0.0.1:{port}"], 1, "ray://127.0.0.1:{port}: Connection refused"),
        (["convert", "{cube}", "--address", "nonsense"], 2, "--address nonsense: not ray://HOST:PORT"),
        (["report", "{here}"], 1, "{here}: no catalogue"),
    ],
)
def test_bad_input_is_one_clear_line(data, tmp_path, arguments, status, message):
    (tmp_path / "empty").mkdir()
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        names = {"here": tmp_path, "cube": data / "red_cube_blue_cylinder.step", "port": unused.getsockname()[1]}
    arguments = [argument.format(**names) for argument in arguments]
    out = ["--out", tmp_path / "out"] if arguments[0] == "convert" else []
    done = batch(*arguments, *out)
    assert done.returncode == status and done.stdout == ""
    assert done.stderr.startswith("trimtess-batch: " + message.format(**names)) and done.stderr.count("\n") == 1


def test_a_folder_that_cannot_be_written_is_one_clear_line(data, tmp_path):
    (tmp_path / "file").write_text("")
    done = batch("convert", data, "--out", tmp_path / "file" / "out")
    assert done.returncode == 1 and done.stderr == f"trimtess-batch: {tmp_path}/file/out/catalogue: Not a directory\n"


@pytest.mark.parametrize(
    "wrong", [[], ["convert"], ["convert", "x"], ["convert", "x", "--out", "y", "--angle", "-1"], ["report"]]
)
def test_wrong_usage_has_status_2(wrong):
    done = batch(*wrong)
    assert done.returncode == 2 and done.stderr.startswith("usage: trimtess-batch")


def test_more_memory_than_a_node_has_is_one_clear_line(data, tmp_path):
    done = batch("convert", data, "--out", tmp_path / "out", "--max-memory", 10**9)
    assert done.returncode == 1 and done.stderr.count("\n") == 1
    assert "--max-memory 1000000000: the largest node has " in done.stderr
