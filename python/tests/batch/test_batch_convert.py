"""One file to one result."""

import json
import os
import pathlib

import pytest

import trimtess
from trimtess.batch import convert as converting
from trimtess.batch import task
from trimtess.batch.errors import FULL
from trimtess.batch.options import Options, result_key
from trimtess.batch.store import Store


@pytest.fixture
def job(tmp_path):
    Store(tmp_path / "out").start("run")
    options = Options(formats=("glb", "ply"), chord_rel=1e-2).canonical()
    return {"out": str(tmp_path / "out"), "run": "run", "options": options, "max_memory": 1 << 30, "workers": 1}


def test_a_file_becomes_a_result_with_every_format(job, data):
    outcome = converting.convert({**job, "path": str(data / "red_cube_blue_cylinder.step")})
    assert outcome["status"] == "whole" and outcome["closed"] and outcome["triangles"] > 12
    assert [output["format"] for output in outcome["outputs"]] == ["glb", "ply"]
    out = pathlib.Path(job["out"])
    for output in outcome["outputs"]:
        assert (out / output["path"]).stat().st_size == output["bytes"] > 0
    assert set(outcome["seconds"]) == {"hash", "read", "prepare", "tessellate", "check", "write"}
    stored = json.loads((out / "objects" / outcome["key"][:2] / outcome["key"] / "result.json").read_text())
    assert stored["outputs"] == outcome["outputs"]
    assert list((out / ".tmp" / "run").iterdir()) == []


def test_area_and_volume_are_those_of_the_solids(job, data):
    # A cube and a cylinder inscribed in the tolerance: the mesh is a little less.
    outcome = converting.convert({**job, "path": str(data / "red_cube_blue_cylinder.step")})
    model = trimtess.read(str(data / "red_cube_blue_cylinder.step"))
    exact = model.prepare().tessellate(chord_rel=1e-5).check()
    assert outcome["area_mm2"] == pytest.approx(exact.area, rel=0.02)
    assert outcome["volume_mm3"] == pytest.approx(exact.volume, rel=0.02)


def test_the_same_content_is_converted_once(job, data, tmp_path):
    first = converting.convert({**job, "path": str(data / "red_cube_blue_cylinder.step")})
    (tmp_path / "copy.stp").write_bytes((data / "red_cube_blue_cylinder.step").read_bytes())
    mesh = pathlib.Path(job["out"], first["outputs"][0]["path"])
    before = mesh.stat().st_mtime_ns
    second = converting.convert({**job, "path": str(tmp_path / "copy.stp")})
    assert second["reused"] and not first["reused"] and mesh.stat().st_mtime_ns == before
    assert {**second, "reused": False} == first


def test_a_file_that_is_no_step_is_refused_and_stored_without_outputs(job, tmp_path):
    (tmp_path / "no.step").write_text("solid ascii")
    outcome = converting.convert({**job, "path": str(tmp_path / "no.step")})
    assert outcome["status"] == "refused" and outcome["outputs"] == [] and outcome["message"]
    assert "\n" not in outcome["message"] and converting.convert({**job, "path": str(tmp_path / "no.step")})["reused"]


def test_messages_do_not_name_the_scratch_folder(job, shared):
    outcome = converting.convert({**job, "path": str(shared / "attack" / "shift_1e15.step")})
    assert outcome["status"] == "refused" and outcome["message"].startswith("cannot write mesh.glb: ")


def test_a_limit_is_not_stored(job, data):
    outcome = converting.convert({**job, "path": str(data / "nist_ctc05.step"), "max_memory": 1000})
    assert outcome["status"] == "limit" and outcome["message"]
    assert not converting.convert({**job, "path": str(data / "nist_ctc05.step")})["reused"]


def test_a_missing_file_is_unreadable(job, tmp_path):
    outcome = converting.convert({**job, "path": str(tmp_path / "gone.step")})
    assert outcome["status"] == "unreadable" and outcome["message"] == "No such file or directory"


@pytest.mark.parametrize("number", FULL)
def test_a_full_disk_is_told_apart(job, data, monkeypatch, number):
    def fail(*_args, **_options):
        raise OSError(number, "no room")

    monkeypatch.setattr(converting, "write", fail)
    outcome = converting.convert({**job, "path": str(data / "red_cube_blue_cylinder.step")})
    assert outcome["status"] == "full" and "no room" in outcome["message"]


def test_a_worker_gives_files_back_when_its_patience_ends(job, data):
    cube = str(data / "red_cube_blue_cylinder.step")
    bundle = {"name": "0", "paths": [cube] * 5, "version": trimtess.__version__, "patience": 0.0}
    bundle["job"] = {**job, "seconds": 60.0}
    assert len(task.run_bundle(bundle)["outcomes"]) == 1
    assert len(task.run_bundle({**bundle, "patience": 60.0})["outcomes"]) == 5
    task.SERVER.stop()


@pytest.mark.parametrize("where, at", [("in work", 2), ("between files", None)])
def test_a_lost_worker_leaves_which_file_it_was_at(job, data, monkeypatch, where, at):
    cube = str(data / "red_cube_blue_cylinder.step")
    bundle = {"name": "7", "paths": [cube] * 5, "version": trimtess.__version__, "patience": 60.0}
    bundle["job"] = {**job, "seconds": 60.0}
    assert len(task.run_bundle(bundle)["outcomes"]) == 5 and not list(task.scratch(job).iterdir())
    name = "convert" if where == "in work" else "start"
    before = getattr(task.SERVER, name)
    # `convert` starts the server, too.
    left = [2 if where == "in work" else 4]

    def die_at_the_third(*arguments):
        if not left[0]:
            os._exit(9)
        left[0] -= 1
        return before(*arguments)

    monkeypatch.setattr(task.SERVER, name, die_at_the_third)
    child = os.fork()
    if child == 0:
        task.run_bundle(bundle)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9
    assert len(list(task.scratch(job).iterdir())) == 1
    assert task.Marks.take(bundle["job"], "7") == at and not list(task.scratch(job).iterdir())
    task.SERVER.stop()


def test_a_server_that_ends_as_it_starts_costs_no_file(job, data, monkeypatch):
    cube = str(data / "red_cube_blue_cylinder.step")
    bundle = {"name": "8", "paths": [cube] * 3, "version": trimtess.__version__, "patience": 60.0}
    bundle["job"] = {**job, "seconds": 60.0}
    convert = task.SERVER.convert

    def convert_and_lose_the_server(job):
        outcome = convert(job)
        task.SERVER.stop()
        monkeypatch.setattr(task.sys, "executable", "false")
        return outcome

    # What was done before is told; the rest is given back.
    monkeypatch.setattr(task.SERVER, "convert", convert_and_lose_the_server)
    assert len(task.run_bundle(bundle)["outcomes"]) == 1
    with pytest.raises(task.ServerLost, match="the process that starts conversions was lost .status 1."):
        task.run_bundle(bundle)
    assert task.Marks.take(job, "8") is None


def test_keys_differ_by_content_options_and_version():
    options = Options().canonical()
    keys = {
        result_key("a", options, "1"),
        result_key("b", options, "1"),
        result_key("a", options, "2"),
        result_key("a", Options(angle=10).canonical(), "1"),
    }
    assert len(keys) == 4
    assert Options(formats=("png", "glb")).canonical() == Options(formats=("glb", "png", "glb")).canonical()
    # The size of pictures counts where there are pictures.
    assert Options(size=(1, 1)).canonical() == options
    assert Options.from_canonical(options) == Options()
