"""Arrays of meshes: views without copies, read-only, kept alive; parts, instances and all of it flattened."""

import gc
import weakref

import numpy as np
import pytest

import trimtess

COLUMNS = {
    "positions": (3, np.float64),
    "normals": (3, np.float32),
    "uv": (2, np.float32),
    "triangles": (3, np.uint32),
    "face_ids": (None, np.uint32),
}


def address(array: np.ndarray) -> int:
    return array.__array_interface__["data"][0]


def resident() -> int:
    """Resident memory of this process, bytes."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096


def test_shapes_and_types_are_as_documented(large):
    mesh = large.tessellate()
    for arrays in [mesh, mesh.flattened(), *mesh.parts]:
        vertices, triangles = len(arrays.positions), len(arrays.triangles)
        for name, (columns, kind) in COLUMNS.items():
            array = getattr(arrays, name)
            rows = triangles if name in ("triangles", "face_ids") else vertices
            assert array.shape == ((rows, columns) if columns else (rows,)), name
            assert array.dtype == kind and array.flags.c_contiguous and array.flags.aligned, name
        assert arrays.triangles.max() < vertices
        assert np.allclose(np.linalg.norm(arrays.normals, axis=1), 1, atol=1e-5)


def test_arrays_are_views_of_the_same_memory(large):
    mesh = large.tessellate()
    part = mesh.parts[0]
    for name in COLUMNS:
        array, again = getattr(part, name), getattr(mesh.parts[0], name)
        assert array is not again and address(array) == address(again), name
        assert not array.flags.owndata, name
    # One part that is placed where it is stated: the flattened arrays are the part's.
    assert len(mesh.instances) == 1
    for name in COLUMNS:
        assert address(getattr(mesh, name)) == address(getattr(part, name)), name
        assert address(getattr(mesh.flattened(), name)) == address(getattr(part, name)), name
    assert [address(line) for line in part.edges] == [address(line) for line in mesh.parts[0].edges]


def test_flattened_arrays_are_made_once(prepared):
    mesh = prepared.tessellate()
    assert len(mesh.instances) > 1
    for name in COLUMNS:
        assert address(getattr(mesh, name)) == address(getattr(mesh.flattened(), name)), name


def test_arrays_are_read_only(large):
    part = large.tessellate().parts[0]
    for name in COLUMNS:
        array = getattr(part, name)
        with pytest.raises(ValueError):
            array[0] = 0
        with pytest.raises(ValueError):
            array.setflags(write=True)
    for line in part.edges:
        assert not line.flags.writeable


def test_arrays_outlive_their_mesh(large):
    mesh = large.tessellate(chord_rel=1e-4)
    positions, triangles = mesh.positions, mesh.parts[0].triangles
    expected = positions.copy(), triangles.copy()
    del mesh
    gc.collect()
    # Memory that was freed by mistake would be used again here.
    other = [large.tessellate(chord_rel=1e-4) for _ in range(3)]
    assert np.array_equal(positions, expected[0]) and np.array_equal(triangles, expected[1])
    del other


def test_memory_is_freed_with_the_last_array(large):
    array = large.tessellate().positions
    slice_of_it = array[1:]
    owner = weakref.ref(array.base)
    del array
    gc.collect()
    assert owner() is not None, "the slice needs it"
    del slice_of_it
    gc.collect()
    assert owner() is None


def test_reading_arrays_takes_no_memory(large):
    mesh = large.tessellate(chord_rel=1e-6, angle=1)
    part = mesh.parts[0]
    size = sum(getattr(part, name).nbytes for name in COLUMNS)
    assert size > 16 << 20, "large enough to measure"
    sums = [getattr(part, name)[::1000].sum() for name in COLUMNS]
    before = resident()
    arrays = [getattr(mesh, name) for name in COLUMNS] + [getattr(part, name) for name in COLUMNS]
    sums += [array.max() for array in arrays]
    assert resident() - before < size // 10
    assert np.isfinite(sums).all()


def test_flattened_meshes_are_the_placed_parts(prepared):
    mesh = prepared.tessellate()
    flat, vertex, triangle, first_face = mesh.flattened(), 0, 0, 0
    lines = iter(flat.edges)
    for instance in mesh.instances:
        part, transform = mesh.parts[instance.part], instance.transform
        rows = slice(vertex, vertex + len(part.positions))
        corners = slice(triangle, triangle + len(part.triangles))
        placed = part.positions @ transform[:3, :3].T + transform[:3, 3]
        assert np.allclose(flat.positions[rows], placed, atol=1e-9)
        assert np.allclose(flat.normals[rows], part.normals @ transform[:3, :3].T, atol=1e-5)
        assert np.array_equal(flat.uv[rows], part.uv)
        assert np.array_equal(flat.triangles[corners], part.triangles + vertex)
        assert np.array_equal(flat.face_ids[corners], part.face_ids + first_face)
        for line in part.edges:
            assert np.allclose(next(lines), line @ transform[:3, :3].T + transform[:3, 3], atol=1e-9)
        vertex, triangle = rows.stop, corners.stop
        first_face += len(part.face_colours)
    assert next(lines, None) is None
    assert (vertex, triangle) == (len(flat.positions), len(flat.triangles))
    assert (mesh.vertex_count, mesh.triangle_count, mesh.face_count) == (vertex, triangle, first_face)


def test_edges_are_named_and_face_ids_are_faces_of_the_part(prepared):
    for part in prepared.tessellate().parts:
        assert len(part.edges) == len(part.edge_ids) > 0
        assert part.edge_ids == sorted(set(part.edge_ids))
        assert all(line.shape[1] == 3 and len(line) >= 2 for line in part.edges)
        assert set(part.face_ids) == set(range(len(part.face_colours)))


def test_area_and_volume_follow_from_the_arrays(prepared):
    mesh = prepared.tessellate()
    a, b, c = (mesh.positions[mesh.triangles[:, k]] for k in range(3))
    check = mesh.check()
    assert np.isclose(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2, check.area)
    assert np.isclose((a * np.cross(b, c)).sum() / 6, check.volume)
    outward = (np.cross(b - a, c - a) * mesh.normals[mesh.triangles[:, 0]]).sum(axis=1)
    assert (outward > 0).all(), "normals point to where triangles are counter-clockwise"


def test_a_mesh_without_triangles_has_empty_arrays():
    empty = b"ISO-10303-21;HEADER;FILE_DESCRIPTION((''),'2;1');FILE_NAME('','',(''),(''),'','','');"
    empty += b"FILE_SCHEMA(('CONFIG_CONTROL_DESIGN'));ENDSEC;DATA;#1=CARTESIAN_POINT('',(0.,0.,0.));ENDSEC;"
    mesh = trimtess.read(empty + b"END-ISO-10303-21;").prepare().tessellate()
    assert mesh.status == 3, "no faces"
    assert mesh.positions.shape == (0, 3) and mesh.triangles.shape == (0, 3) and mesh.face_ids.shape == (0,)
    assert mesh.edges == [] and mesh.parts == []
