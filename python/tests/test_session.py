"""Tests of sessions: changed and drawn tiles, instances, Ctrl-C."""

import math
import os
import signal
import threading

import numpy as np
import pytest
from files import SMALL

import trimtess


def orbit(prepared, frames, **options):
    """Views around the model, at half the distance from which it fits."""
    fitted = prepared.view(size=(640, 480))
    target = np.array(fitted.target)
    arm = 0.5 * (np.array(fitted.eye) - target)
    for k in range(frames):
        angle = 0.2 * k
        turn = np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]])
        yield trimtess.View(target + turn @ arm, target, size=(640, 480), **options)


class Shown:
    """What a program keeps of a session."""

    def __init__(self):
        self.tiles = {}

    def apply(self, frame):
        if frame.whole:
            self.tiles.clear()
        if frame.renumbered is not None:
            kept = [(part, tile) for part, tile in self.tiles if part in frame.renumbered]
            self.tiles = {(frame.renumbered[part], tile): self.tiles[part, tile] for part, tile in kept}
        for key in frame.removed:
            self.tiles.pop(key, None)
        self.tiles.update((tile.key, tile) for tile in frame.changed)

    def sides(self, frame, view=0):
        """How often each side of a drawn triangle is used one way more than the other, in world coordinates."""
        sides = {}
        for row, tiles in frame.drawn(view):
            instance = frame.instances[row]
            for tile in tiles:
                if (instance.part, tile) not in self.tiles:
                    continue  # No triangles.
                mesh = self.tiles[instance.part, tile]
                points = [(row, point.tobytes()) for point in mesh.positions]
                for a, b, c in mesh.triangles:
                    for p, q in ((a, b), (b, c), (c, a)):
                        one, other = points[p], points[q]
                        side, way = ((one, other), 1) if one < other else ((other, one), -1)
                        sides[side] = sides.get(side, 0) + way
        return sides


def pairs(listed):
    """Rows of instances and tiles."""
    return {(row, tile) for row, tiles in listed for tile in tiles.tolist()}


def bytes_of(frame):
    rows = [(tile.key, tile.face, *(getattr(tile, name).tobytes() for name in ("positions", "normals", "uv", "triangles")))
            for tile in frame.changed]
    drawn = [(row, tiles.tobytes()) for row, tiles in frame.drawn()]
    return frame.whole, rows, frame.removed, drawn


def test_frames_send_what_changes_and_all_of_a_closed_part_is_closed(prepared):
    session, shown = prepared.session(), Shown()
    sent, drawn = [], set()
    for k, view in enumerate(orbit(prepared, 8)):
        frame = session.view(view)
        assert frame.whole == (k == 0)
        assert frame.degraded == []
        assert frame.triangle_count == sum(len(tile.triangles) for tile in frame.changed)
        sent.append(len(frame.changed))
        shown.apply(frame)
        drawn = (drawn - pairs(frame.disappeared())) | pairs(frame.appeared())
        assert drawn and drawn == pairs(frame.drawn()) and len(frame.instances) == 2
    # Everything is in the picture from the distance at which the model fits.
    frame = session.view(prepared.view())
    shown.apply(frame)
    sides = shown.sides(frame)
    assert sides and not any(sides.values())
    again = session.view(prepared.view())
    assert (again.changed, again.removed, again.triangle_count) == ([], [], 0)
    assert (again.appeared(), again.disappeared()) == ([], [])
    assert [row for row, _ in again.drawn()] == [row for row, _ in frame.drawn()]
    session.forget()
    whole = session.view(prepared.view())
    assert whole.whole and {tile.key for tile in whole.changed} == set(shown.tiles)
    assert sum(sent[1:]) < 7 * len(whole.changed), "later frames send some tiles"


def test_the_number_of_workers_changes_no_byte(large):
    sessions = [large.session(workers=workers) for workers in (1, 3)]
    for view in orbit(large, 4, deviation_px=0.2):
        one, other = (bytes_of(session.view(view)) for session in sessions)
        assert one == other


def test_arrays_outlive_the_session(prepared):
    frame = prepared.session().view(prepared.view())
    tile = frame.changed[0]
    positions, triangles = tile.positions, tile.triangles
    before = positions.copy()
    del frame, tile
    assert np.array_equal(positions, before)
    assert not positions.flags.writeable and positions.dtype == np.float64 and positions.shape[1] == 3
    assert triangles.dtype == np.uint32 and triangles.max() == len(positions) - 1


def test_edges_are_sent_on_request(prepared):
    assert prepared.session().view(prepared.view()).edges == []
    edges = prepared.session(edges=True).view(prepared.view()).edges
    assert edges and all(points.shape[1] == 3 and len(points) >= 2 for _, _, points in edges)


def test_two_views_draw_their_own_tiles(prepared):
    near, far = prepared.view("front"), prepared.view("back")
    away = trimtess.View((1e5, 0, 0), (2e5, 0, 0), size=(64, 64))
    frame = prepared.session().view(near, far, away)
    assert frame.drawn(0) and frame.drawn(1) and frame.drawn(2) == []
    with pytest.raises(trimtess.RangeError, match="below 3"):
        frame.drawn(3)


def test_instances_come_move_and_go(prepared):
    session, view = prepared.session(), prepared.view()
    frame = session.view(view)
    keys = session.keys
    assert len(set(keys)) == 2
    assert (frame.added_instances, frame.changed_instances, frame.removed_instances) == (keys, [], [])
    aside = np.eye(4)
    aside[0, 3] = 3.0
    new = session.add_instance(1, aside, name="again")
    frame = session.view(view)
    assert [instance.name for instance in frame.instances][-1] == "again"
    assert np.array_equal(frame.instances[-1].transform, aside)
    assert (frame.added_instances, frame.removed_instances) == ([new], [])
    session.remove_instance(keys[0])
    session.move_instance(new, np.eye(4))
    frame = session.view(view)
    assert session.keys == [keys[1], new] and np.array_equal(frame.instances[1].transform, np.eye(4))
    assert [instance.key for instance in frame.instances] == session.keys
    assert (frame.added_instances, frame.removed_instances) == ([], [keys[0]]) and new in frame.changed_instances
    for work in (
        lambda: session.remove_instance(keys[0]),
        lambda: session.remove_instances([new, keys[0]]),
        lambda: session.move_instance(7, np.eye(4)),
    ):
        with pytest.raises(trimtess.RangeError, match="key"):
            work()
    session.remove_instances([new, keys[1]])
    assert not session.keys and len(session.view(view).instances) == 0
    # A whole frame of nothing.
    last = session.add_instance(0)
    assert len(session.view(view).instances) == 1
    session.remove_instances([last])
    session.forget()
    assert len(session.view(view).instances) == 0
    with pytest.raises(trimtess.RangeError, match="part"):
        session.add_instance(99)
    with pytest.raises(trimtess.RangeError, match="uniform scale"):
        session.add_instance(0, np.diag([1.0, 2.0, 1.0, 1.0]))
    with pytest.raises(trimtess.RangeError, match="last row"):
        session.add_instance(0, np.ones((4, 4)))


def test_parts_and_instances_are_hidden_coloured_and_refined(prepared):
    session, view = prepared.session(), prepared.view()
    frame = session.view(view)
    triangles = frame.triangle_count
    first, second = session.keys
    session.set_instance(first, visible=False, colour=(1, 0, 0, 1))
    session.set_part(1, colour=(0, 0, 1, 0.5))
    frame = session.view(view)
    assert [row for row, _ in frame.drawn()] == [1] and frame.changed == []
    assert [instance.visible for instance in frame.instances] == [False, True]
    assert [instance.colour for instance in frame.instances] == [(1, 0, 0, 1), (0, 0, 1, 0.5)]
    for colour in ([1, 0, 0], np.array([1, 0, 0, 1], np.float32)):
        session.set_instance(first, visible=False, colour=colour)
    told = session.instance_attributes(first)
    assert (told.visible, told.colour, told.tolerance_scale, told.priority) == (False, (1, 0, 0, 1), 1, 1)
    assert "hidden" in repr(told) and session.part_attributes(1).colour == (0, 0, 1, 0.5)
    session.set_instance(first)
    for part in (0, 1):
        session.set_part(part, tolerance_scale=1e-3, priority=2)
    frame = session.view(view)
    assert len(frame.drawn()) == 2 and frame.instances[1].visible
    assert len({part for part, _ in (tile.key for tile in frame.changed)}) == 1, "the cylinder; the cube is flat"
    assert frame.triangle_count > triangles
    for work, words in [
        (lambda: session.set_part(2), "part is 2, not below 2"),
        (lambda: session.part_attributes(7), "part is 7"),
        (lambda: session.set_instance(7), "not that of an instance"),
        (lambda: session.instance_attributes(7), "not that of an instance"),
        (lambda: session.set_part(0, tolerance_scale=0), "tolerance_scale is 0, not a finite number above 0"),
        (lambda: session.set_instance(second, priority=math.nan), "priority is NaN"),
        (lambda: session.set_instance(second, colour=(0, 0, 0, 2)), "four numbers from 0 to 1"),
        (lambda: session.set_instance(second, colour=[0, 0]), "colour is .0.0, 0.0., not three or four numbers"),
    ]:
        with pytest.raises(trimtess.RangeError, match=words):
            work()
    assert session.part_attributes(0).tolerance_scale == 1e-3


def test_a_budget_defers_and_a_still_camera_catches_up(large):
    session, view = large.session(budget_ms=0.05, workers=1), large.view(deviation_px=0.05)
    deferred = [session.view(view).deferred for _ in range(400)]
    assert deferred[0] > 0 and deferred[-1] == 0


def test_a_frame_tells_that_limits_made_it_coarser(large):
    view = large.view()
    assert large.session().view(view).shortfall is None
    session = large.session(max_memory=100_000)
    first, again = session.view(view), session.view(view)
    assert "100000 bytes of memory" in first.shortfall
    assert again.changed == [] and again.shortfall == first.shortfall


@pytest.mark.parametrize(
    ("arguments", "keywords"),
    [
        (((0, 0, 0), (0, 0, 0)), {}),
        (((0, 0, math.nan), (0, 0, 0)), {}),
        (((0, 0, 1), (0, 0, 0)), {}),
        (((1, 0, 0), (0, 0, 0)), {"fov": 180}),
        (((1, 0, 0), (0, 0, 0)), {"height": 0}),
        (((1, 0, 0), (0, 0, 0)), {"size": (0, 480)}),
        (((1, 0, 0), (0, 0, 0)), {"deviation_px": -1}),
    ],
)
def test_views_that_no_camera_has_are_refused(arguments, keywords):
    with pytest.raises(trimtess.RangeError, match="view"):
        trimtess.View(*arguments, **keywords)


def test_views_tell_what_they_are():
    view = trimtess.View([10, 0, 0], np.zeros(3), fov=40, size=(320, 200), deviation_px=2)
    assert (view.eye, view.target, view.up) == ((10, 0, 0), (0, 0, 0), (0, 0, 1))
    assert (round(view.fov, 12), view.height, view.size, view.deviation_px) == (40, None, (320, 200), 2)
    assert trimtess.View((10, 0, 0), (0, 0, 0), height=5).height == 5


def clip_matrix(eye, size, middle=0.0):
    """Of a camera at `eye` on the x axis that looks back along it, with a full vertical field of view of 40 degrees."""
    focal = 1 / math.tan(math.radians(20))
    rows = np.array([[0, focal * size[1] / size[0], 0, 0], [0, 0, focal, 0], [0, 0, 0, 1], [-1, 0, 0, eye]])
    rows[0] += middle * rows[3]
    return rows


def test_a_view_has_the_camera_of_a_matrix():
    view = trimtess.View.from_matrix(clip_matrix(10, (320, 200)), (320, 200), near=0.5, deviation_px=2)
    assert np.allclose([view.eye, view.up], [(10, 0, 0), (0, 0, 1)])
    assert view.target[0] < 10 and np.allclose(view.target[1:], 0)
    assert (round(view.fov, 9), view.size, view.deviation_px) == (40, (320, 200), 2)
    # An eye of a headset: a fifth of half a picture is missing on one side.
    aside = trimtess.View.from_matrix(clip_matrix(10, (320, 200), 0.2).tolist(), (320, 200))
    assert (aside.eye, aside.size) == (view.eye, (384, 200))


@pytest.mark.parametrize(
    ("matrix", "keywords"),
    [
        (np.zeros((4, 4)), {}),
        (clip_matrix(10, (320, 200)) + np.eye(4), {}),
        (clip_matrix(10, (320, 200)), {"near": -1}),
        (clip_matrix(10, (320, 200)), {"angle": 0}),
    ],
)
def test_matrices_of_no_camera_are_refused(matrix, keywords):
    with pytest.raises(trimtess.RangeError, match="view"):
        trimtess.View.from_matrix(matrix, (320, 200), **keywords)


def test_ctrl_c_cancels_a_frame_and_the_session_goes_on(large, interruptible):
    session = large.session(workers=1)
    view = large.view(size=(8192, 8192), deviation_px=1e-4)
    timer = threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        session.view(view)
    frame = session.view(large.view())
    assert frame.whole and frame.changed


def test_a_session_serves_one_thread_at_a_time(large):
    session, view = large.session(workers=1), large.view(size=(4096, 4096), deviation_px=1e-3)
    refused = []

    def work():
        session.view(view)

    thread = threading.Thread(target=work)
    thread.start()
    while thread.is_alive() and not refused:
        try:
            session.keys
        except RuntimeError as why:
            refused.append(str(why))
    thread.join()
    assert refused == ["another thread is using the session"]


@pytest.mark.parametrize("keep_faces", [False, True])
def test_a_session_goes_on_with_a_file_that_has_changed(keep_faces):
    before = trimtess.read(SMALL).prepare(keep_faces=keep_faces)
    text = SMALL.read_text()
    assert text.count(", 0.00500000000000000 )") == 3, "the cylinder and its circles"
    model = trimtess.read(text.replace(", 0.00500000000000000 )", ", 0.00490000000000000 )").encode(), name=SMALL.stem)
    cube = [part.name for part in model.parts].index("red_cube")
    after, fresh = model.prepare(like=before, keep_faces=keep_faces), model.prepare()
    assert after.tessellate().positions.tobytes() == fresh.tessellate().positions.tobytes()
    view = before.view(size=(640, 480))
    session, shown, other = before.session(), Shown(), Shown()
    frame = session.view(view)
    assert frame.whole and frame.renumbered is None
    shown.apply(frame)
    session.update(after)
    frame = session.view(view)
    assert frame.renumbered == {cube: cube} and not frame.whole
    assert {part for part, _ in (tile.key for tile in frame.changed)} == {1 - cube}
    shown.apply(frame)
    other.apply(fresh.session().view(view))
    assert {key: tile.positions.tobytes() for key, tile in shown.tiles.items()} == {
        key: tile.positions.tobytes() for key, tile in other.tiles.items()
    }
    assert not any(shown.sides(frame).values())
