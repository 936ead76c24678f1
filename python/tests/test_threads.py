"""Long work: progress, Ctrl-C, other threads, forks."""

import multiprocessing
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from files import LARGE, SMALL

import trimtess


def test_progress_is_told_on_the_callers_thread_and_ends_with_the_total(tmp_path):
    told = []

    def progress(stage, done, total):
        told.append((stage, done, total, threading.get_ident()))

    prepared = trimtess.read(LARGE, progress=progress).prepare(progress=progress)
    mesh = prepared.tessellate(progress=progress)
    mesh.save(tmp_path / "mesh.stl", progress=progress)
    assert {ident for *_, ident in told} == {threading.get_ident()}
    stages = [stage for stage, *_ in told]
    assert list(dict.fromkeys(stages)) == ["read", "prepare", "tessellate", "write"]
    for stage in ("read", "prepare", "tessellate", "write"):
        counts = [(done, total) for of, done, total, _ in told if of == stage]
        assert counts == sorted(counts) and counts[-1][0] == counts[-1][1] > 0, stage
    assert all(total > 0 for _, _, total, _ in told), "callers may divide by it"
    assert [total for of, _, total, _ in told if of == "prepare"][-1] == mesh.face_count


def test_progress_is_not_told_before_the_total_is_known():
    told = []
    with pytest.raises(trimtess.ReadError):
        trimtess.read(b"no STEP file", progress=lambda *of: told.append(of))
    assert told == []


def test_an_exception_of_progress_ends_the_work(large):
    class Enough(Exception):
        pass

    calls = []

    def progress(*told):
        calls.append(told)
        raise Enough

    start = time.monotonic()
    with pytest.raises(Enough):
        large.tessellate(chord_rel=1e-7, angle=0.2, workers=1, progress=progress)
    assert len(calls) == 1 and calls[0][1] < calls[0][2], "not at the end"
    assert large.tessellate(chord_rel=1e-2).status == large.tessellate().status, "the model is as it was"
    assert time.monotonic() - start < 60


def test_a_save_that_progress_ends_leaves_no_file(large, tmp_path):
    class Enough(Exception):
        pass

    def progress(*_):
        raise Enough

    mesh = large.tessellate(chord_rel=1e-4, angle=5)
    with pytest.raises(Enough):
        mesh.save(tmp_path / "mesh.obj", progress=progress)
        pytest.fail("no progress")
    assert not any(path.suffix == ".part" for path in tmp_path.iterdir())


@pytest.mark.parametrize("stage", ["prepare", "tessellate"])
def test_ctrl_c_is_honoured_between_faces_and_tiles(stage, large, interruptible):
    counts = []

    def progress(_, done, total):
        counts.append((done, total))
        if len(counts) == 1:
            # As a terminal does; the handler runs later, in the thread that waits.
            os.kill(os.getpid(), signal.SIGINT)

    work = {
        "prepare": lambda: trimtess.read(LARGE).prepare(workers=1, progress=progress),
        "tessellate": lambda: large.tessellate(chord_rel=1e-7, angle=0.2, workers=1, progress=progress),
    }
    with pytest.raises(KeyboardInterrupt):
        work[stage]()
        # A fast machine may prepare the file before the signal is seen.
        time.sleep(1)
    if stage == "tessellate":
        assert counts[-1][0] < counts[-1][1], "not at the end"


def test_other_threads_run_meanwhile(large):
    done = threading.Event()

    def work():
        large.tessellate(chord_rel=1e-6, angle=0.5, workers=1)
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    ticks, longest, last = 0, 0.0, time.monotonic()
    while not done.is_set():
        now = time.monotonic()
        ticks, longest, last = ticks + 1, max(longest, now - last), now
        time.sleep(0.001)
    thread.join()
    assert ticks > 20, "the lock is free while the mesh is made"
    assert longest < 1


def test_threads_share_a_model_and_make_the_same_mesh(large):
    meshes = [None] * 4

    def work(k):
        meshes[k] = large.tessellate(chord_rel=1e-4, workers=1 + k % 3)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for mesh in meshes[1:]:
        for name in ("positions", "normals", "uv", "triangles", "face_ids"):
            assert np.array_equal(getattr(mesh, name), getattr(meshes[0], name)), name


def running():
    """Ids of this process's threads. One that was joined may still be listed, with the kernel's mark for exit."""
    ids = set()
    for stat in pathlib.Path("/proc/self/task").glob("*/stat"):
        try:
            mark = int(stat.read_text().rpartition(")")[2].split()[6])
        except (FileNotFoundError, ProcessLookupError):
            continue
        if not mark & 4:
            ids.add(stat.parent.name)
    return ids


@pytest.mark.skipif(not pathlib.Path("/proc/self/task").is_dir(), reason="the system does not list threads")
def test_threads_have_ended_once_a_call_returns(prepared):
    # Compares ids, not counts: a thread of an earlier test that Python has joined may end only now.
    before = running()
    for call in (
        lambda: trimtess.read(SMALL, workers=64),
        lambda: trimtess.read(SMALL).prepare(workers=64),
        lambda: prepared.tessellate(workers=64),
        prepared.view,
    ):
        result = call()
        assert running() <= before, result
    session = prepared.session(workers=64)
    assert len(running() - before) == 64
    del session
    assert running() <= before


@pytest.mark.skipif(sys.platform != "linux", reason="the system does not limit threads")
def test_refused_threads_are_no_defect():
    program = (
        "import os, resource, sys, trimtess\n"
        "model = trimtess.read(sys.argv[1], workers=1)\n"
        "prepared = model.prepare(workers=1)\n"
        # The limit does not hold for root.
        "os.getuid() or os.setuid(65534)\n"
        "resource.setrlimit(resource.RLIMIT_NPROC, (1, 1))\n"
        "for call in (model.prepare, prepared.tessellate, prepared.session):\n"
        "    try:\n"
        "        call(workers=2)\n"
        "    except trimtess.TessellateError as error:\n"
        "        print(error)\n"
    )
    told = subprocess.run([sys.executable, "-c", program, str(SMALL)], capture_output=True, text=True, check=False)
    assert told.returncode == 0, told.stderr
    refused = told.stdout.splitlines()
    assert len(refused) == 3
    for words in refused:
        assert words.startswith("cannot start threads: ") and words.endswith("; pass a smaller workers")


def _count(queue):
    queue.put(trimtess.read(SMALL).prepare().tessellate().triangle_count)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system does not fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_can_work():
    expected = trimtess.read(SMALL).prepare().tessellate().triangle_count
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    child = context.Process(target=_count, args=(queue,))
    child.start()
    assert queue.get(timeout=60) == expected
    child.join(60)
    assert child.exitcode == 0
