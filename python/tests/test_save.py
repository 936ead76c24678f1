"""Files: the same bytes as the program's, whole or not at all, with limits on rounding."""

import hashlib
import os
import signal
import stat
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from files import LARGE, SHARED, SMALL, corpus

import trimtess

FORMATS = ["glb", "ply", "obj", "stl"]


def digest(path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def run(program, file, output, *options):
    """Runs the program and returns its status."""
    return subprocess.run([program, "-q", "tessellate", file, "-o", output, *options], check=False).returncode


@pytest.mark.parametrize("ending", FORMATS)
@pytest.mark.parametrize("file", [SMALL, LARGE], ids=lambda file: file.stem)
def test_files_equal_those_of_the_program(file, ending, program, tmp_path):
    for options, arguments in [
        ((), {}),
        (("--chord-rel", "1e-2", "--angle", "30"), {"chord_rel": 1e-2, "angle": 30}),
        (("--chord", "0.02", "--max-edge", "3", "--workers", "1"), {"chord": 0.02, "max_edge": 3, "workers": 1}),
    ]:
        theirs, ours = tmp_path / f"program.{ending}", tmp_path / f"python.{ending}"
        status = run(program, file, theirs, *options)
        mesh = trimtess.read(file).prepare().tessellate(**arguments)
        saved = mesh.save(ours)
        assert digest(ours) == digest(theirs), options
        assert saved.status == mesh.status == status
        assert saved.triangles == mesh.triangle_count - saved.collapsed_triangles


def test_files_of_the_corpus_equal_those_of_the_program(program, tmp_path):
    files = corpus()
    if not files:
        pytest.skip(f"{SHARED} has no corpus")
    different = []
    for file in files:
        theirs, ours = tmp_path / "program.glb", tmp_path / "python.glb"
        status = run(program, file, theirs, "--chord-rel", "1e-3", "--angle", "20")
        try:
            mesh = trimtess.read(file).prepare().tessellate(chord_rel=1e-3, angle=20)
            saved = mesh.save(ours).status
        except trimtess.Error as error:
            if status != 1:
                different.append(f"{file.name}: {error}, and the program's status is {status}")
            continue
        if status == 1 or digest(ours) != digest(theirs) or saved != status:
            different.append(f"{file.name}: status {saved} and {status}")
    assert not different, different


def test_recentred_files_equal_those_of_the_program(program, tmp_path):
    theirs, ours = tmp_path / "program.stl", tmp_path / "python.stl"
    assert run(program, SMALL, theirs, "--recenter") == 0
    saved = trimtess.read(SMALL).prepare().tessellate().save(ours, recenter=True)
    assert digest(ours) == digest(theirs)
    assert any(saved.offset_mm)


def test_compact_files_equal_those_of_the_program(program, tmp_path):
    theirs, ours = tmp_path / "program.glb", tmp_path / "python.glb"
    assert run(program, SMALL, theirs, "--glb", "instanced,quantized,compressed") == 0
    mesh = trimtess.read(SMALL).prepare().tessellate()
    mesh.save(ours, glb=["instanced", "quantized", "compressed"])
    assert digest(ours) == digest(theirs)
    for path, words in [(ours, ["small"]), (tmp_path / "x.stl", ["quantized"])]:
        with pytest.raises(ValueError, match="glb"):
            mesh.save(path, glb=words)


def test_levels_of_detail_equal_those_of_the_program(program, tmp_path):
    theirs, ours = tmp_path / "program.glb", tmp_path / "python.glb"
    assert run(program, SMALL, theirs, "--levels", "2", "--chord", "0.01", "--glb", "instanced,quantized") == 0
    prepared = trimtess.read(SMALL).prepare()
    mesh, *levels = [prepared.tessellate(chord=0.01 * 4**k, angle=20 * 2**k) for k in range(3)]
    mesh.save(ours, glb=["instanced", "quantized"], levels=levels)
    assert digest(ours) == digest(theirs)
    other = trimtess.read(LARGE).prepare().tessellate()
    for path, wrong in [(ours, levels[::-1]), (ours, [other]), (ours, [mesh]), (tmp_path / "x.stl", levels)]:
        with pytest.raises(ValueError, match="levels"):
            mesh.save(path, levels=wrong)


def test_flattened_arrays_are_those_of_a_ply(prepared, tmp_path):
    path = tmp_path / "x.ply"
    mesh = prepared.tessellate()
    mesh.save(path)
    head, _, data = path.read_bytes().partition(b"end_header\n")
    assert b"property double x" in head
    vertex = np.dtype([("position", "<f8", 3), ("normal", "<f4", 3)])
    face = np.dtype([("count", "u1"), ("corners", "<u4", 3), ("face_id", "<u4")])
    vertices = np.frombuffer(data, vertex, mesh.vertex_count)
    faces = np.frombuffer(data, face, mesh.triangle_count, vertices.nbytes)
    assert np.array_equal(vertices["position"], mesh.positions)
    assert np.array_equal(vertices["normal"], mesh.normals)
    assert np.array_equal(faces["corners"], mesh.triangles)
    assert np.array_equal(faces["face_id"], mesh.face_ids)




def test_rounding_beyond_a_tenth_of_the_tolerance_is_refused_with_numbers(tmp_path):
    mesh = trimtess.read(LARGE).prepare().tessellate(chord=1e-5, angle=60)
    with pytest.raises(trimtess.RoundingError) as told:
        mesh.save(tmp_path / "x.stl")
    assert told.value.moved > told.value.allowed == pytest.approx(1e-6)
    assert len(told.value.place) == 3 and isinstance(told.value.recenter_helps, bool)
    assert list(tmp_path.iterdir()) == []
    assert mesh.save(tmp_path / "x.ply").rounding_mm <= told.value.allowed


@pytest.mark.parametrize("name", ["x", "x.step", "x."])
def test_unknown_endings_are_refused(prepared, tmp_path, name):
    with pytest.raises(trimtess.FormatError) as told:
        prepared.tessellate().save(tmp_path / name)
    assert told.value.extension == name.partition(".")[2] and ".glb" in str(told.value)
    assert isinstance(told.value, ValueError)


def test_a_file_that_cannot_be_written_is_an_os_error_and_leaves_nothing(prepared, tmp_path):
    mesh = prepared.tessellate()
    with pytest.raises(OSError) as told:
        mesh.save(tmp_path / "missing" / "x.glb")
    assert isinstance(told.value, trimtess.SaveError) and told.value.errno == 2
    assert told.value.path == told.value.filename == str(tmp_path / "missing" / "x.glb")
    full = "/dev/full"
    if os.path.exists(full):
        link = tmp_path / "x.glb"
        link.symlink_to(full)
        with pytest.raises(trimtess.SaveError) as told:
            mesh.save(link)
        assert told.value.errno == 28 and "No space" in told.value.strerror
        assert sorted(tmp_path.iterdir()) == [link]


def test_a_replaced_file_keeps_its_mode_and_old_content_until_the_new_is_whole(prepared, tmp_path):
    path = tmp_path / "x.ply"
    path.write_text("old")
    path.chmod(0o640)
    prepared.tessellate().save(path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert path.read_bytes().startswith(b"ply") and list(tmp_path.iterdir()) == [path]


def test_paths_may_be_strings_and_path_like(prepared, tmp_path):
    mesh = prepared.tessellate()
    assert mesh.save(str(tmp_path / "a.stl")).path == str(tmp_path / "a.stl")
    assert mesh.save(tmp_path / "b.STL").triangles == mesh.triangle_count


def test_a_handler_of_sigterm_leaves_no_temporary_file(large, tmp_path):
    mesh = large.tessellate(chord_rel=1e-5, angle=2)

    def interrupt():
        while not list(tmp_path.glob(".*.part")):
            time.sleep(0.001)
        os.kill(os.getpid(), signal.SIGTERM)

    before = signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    try:
        watcher = threading.Thread(target=interrupt, daemon=True)
        watcher.start()
        with pytest.raises(SystemExit):
            mesh.save(tmp_path / "mesh.obj")
            # A fast machine may write the file before the signal is seen.
            time.sleep(1)
    finally:
        signal.signal(signal.SIGTERM, before)
    assert set(os.listdir(tmp_path)) <= {"mesh.obj"}
