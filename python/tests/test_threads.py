"""Long work: progress, Ctrl-C, other threads, forks."""

import multiprocessing
import os
import signal
import threading
import time

import numpy as np
import pytest
from files import LARGE, SMALL

import trimtess


def test_progress_is_told_on_the_callers_thread_and_ends_with_the_total():
    told = []

    def progress(stage, done, total):
        told.append((stage, done, total, threading.get_ident()))

    prepared = trimtess.read(LARGE, progress=progress).prepare(progress=progress)
    mesh = prepared.tessellate(progress=progress)
    assert {ident for *_, ident in told} == {threading.get_ident()}
    stages = [stage for stage, *_ in told]
    assert list(dict.fromkeys(stages)) == ["read", "prepare", "tessellate"]
    for stage in ("read", "prepare", "tessellate"):
        counts = [(done, total) for of, done, total, _ in told if of == stage]
        assert counts == sorted(counts) and counts[-1][0] == counts[-1][1] > 0, stage
    assert [total for of, _, total, _ in told if of == "prepare"][-1] == mesh.face_count


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


@pytest.fixture
def interruptible():
    """SIGINT raises KeyboardInterrupt, which it does not in what a shell runs in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


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
        assert np.array_equal(mesh.positions, meshes[0].positions)
        assert np.array_equal(mesh.triangles, meshes[0].triangles)


def test_the_number_of_workers_does_not_change_a_bit(prepared):
    one, many = (prepared.tessellate(workers=n) for n in (1, 5))
    for name in ("positions", "normals", "uv", "triangles", "face_ids"):
        assert np.array_equal(getattr(one, name), getattr(many, name)), name


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
