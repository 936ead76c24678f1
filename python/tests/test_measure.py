"""Checks and deviations of meshes."""

import math

import pytest
from files import LARGE, SMALL

import trimtess


def test_a_sound_mesh_is_closed_and_has_no_faults(prepared):
    check = prepared.tessellate(chord_rel=1e-4).check()
    assert check.closed and check.faults == []
    assert (check.open_edges, check.unbalanced_edges, check.defects, check.faces_without_triangles) == (0, 0, 0, 0)
    assert check.components == len(check.parts) == 2 and check.negative_components == 0
    for part in check.parts:
        assert part.closed_in_file and part.closed_in_mesh and part.volume > 0 and part.defect_faces == []
    assert "closed" in repr(check) and "closed in the mesh" in repr(check.parts[0])


def test_free_edges_of_the_file_are_no_faults():
    text = SMALL.read_text()
    # Without one of its faces, the shell of the cube has free edges.
    opened = text.replace("( #46, #40, #52, #48, #42, #38 )", "( #46, #40, #52, #48, #42 )")
    assert opened != text
    check = trimtess.read(opened.encode()).prepare().tessellate().check()
    assert not check.closed and check.defects == 0 and check.faults == []
    assert check.open_edges == check.free_edges > 0
    # The face that the shell lost is a sheet by itself.
    assert [part.closed_in_file for part in check.parts] == [True, False, False]


def test_deviations_are_within_the_tolerance_and_grow_with_a_smaller_one(large):
    mesh = large.tessellate(chord_rel=1e-3)
    deviation = mesh.deviation()
    assert deviation.chord == mesh.chord == pytest.approx(1e-3 * large.diagonal)
    assert 0 < deviation.surfaces.median <= deviation.surfaces.p99 <= deviation.surfaces.p999 * 1.01
    assert deviation.surfaces.worst <= 1.001 and deviation.faults == [] and deviation.faces_over == 0
    assert deviation.worst_mm <= mesh.chord * 1.05
    assert sum(spread.samples for spread in deviation.kinds.values()) == deviation.surfaces.samples
    finer = mesh.deviation(chord=mesh.chord / 100)
    assert finer.surfaces.over > 0 and finer.faults and finer.faces_over > 0
    assert "all" in str(deviation) and "worst" in repr(deviation)


def test_volume_and_area_are_those_of_the_shapes(prepared):
    parts = prepared.tessellate(chord_rel=1e-5, angle=1).check().parts
    cube = min(parts, key=lambda part: part.triangles)
    side = cube.volume ** (1 / 3)
    assert cube.area == pytest.approx(6 * side**2, rel=1e-9)
    cylinder = max(parts, key=lambda part: part.triangles)
    # A cylinder of radius r has the area 2 π r² + 2 V / r. The file's radius is 5 mm.
    radius = 5
    assert 2 * math.pi * radius**2 + 2 * cylinder.volume / radius == pytest.approx(cylinder.area, rel=1e-3)
    assert side == pytest.approx(round(side, 3), rel=1e-6)


def test_the_tolerance_rules_the_number_of_triangles(large):
    counts = [large.tessellate(chord_rel=chord).triangle_count for chord in (1e-2, 1e-3, 1e-4)]
    assert counts == sorted(set(counts))
    assert trimtess.read(LARGE).prepare().tessellate().triangle_count == counts[1], "the default"
