"""Reading: parts, faces, edges, instances, colours, names, units, diagnostics."""

import numpy as np
import pytest
from files import LARGE, SMALL

import trimtess


def test_a_path_and_its_bytes_read_the_same_model():
    of_path, of_bytes = trimtess.read(SMALL), trimtess.read(SMALL.read_bytes(), name=SMALL.stem)
    assert of_path.name == of_bytes.name == SMALL.stem
    assert [part.name for part in of_path.parts] == [part.name for part in of_bytes.parts]
    assert of_path.face_count == of_bytes.face_count > 0
    assert repr(trimtess.read(str(SMALL))) == repr(trimtess.read(bytearray(SMALL.read_bytes()), name=SMALL.stem))


def test_parts_have_faces_edges_and_vertices_that_fit_together():
    model = trimtess.read(SMALL)
    assert sum(len(part.faces) for part in model.parts) == model.face_count
    assert sum(len(part.edges) for part in model.parts) == model.edge_count
    for part in model.parts:
        vertices = part.vertices
        assert vertices.shape[1] == 3 and vertices.dtype == np.float64 and not vertices.flags.writeable
        for edge in part.edges:
            assert max(edge.start, edge.end) < len(vertices)
        for face in part.faces:
            assert all(edge < len(part.edges) for loop in face.loops for edge, _ in loop)
    surfaces = {face.surface for part in model.parts for face in part.faces}
    assert {"plane", "cylinder"} <= surfaces
    assert {edge.curve for part in model.parts for edge in part.edges} >= {"line", "circle"}


def test_colours_are_those_of_the_file():
    model = trimtess.read(SMALL)
    colours = {part.colour for part in model.parts} | {i.colour for i in model.instances}
    colours |= {face.colour for part in model.parts for face in part.faces}
    red, blue = (0.8666666746, 0.3215686381, 0.1568627506), (0.2313725501, 0.380392164, 0.7058823705)
    for rgb in (red, blue):
        assert any(c is not None and np.allclose(c[:3], rgb, atol=1e-6) and c[3] == 1 for c in colours), rgb


def test_instances_have_a_part_and_a_transform():
    model = trimtess.read(SMALL)
    assert len(model.instances) >= 2
    for instance in model.instances:
        assert instance.part < len(model.parts)
        assert instance.transform.shape == (4, 4)
        assert instance.transform[3].tolist() == [0, 0, 0, 1]
        assert abs(np.linalg.det(instance.transform[:3, :3]) - 1) < 1e-12


def test_instances_know_their_assemblies():
    instances = trimtess.read(SMALL.with_name("nested.step")).instances
    paths = [(instance.assemblies, instance.name) for instance in instances]
    of = ["upper pair", "lower pair"]
    assert paths == [(["all", pair], ball) for pair in of for ball in ("left", "right")]
    assert all(instance.assemblies == [] for instance in trimtess.read(LARGE).instances)


def test_units_are_told():
    metres = SMALL.read_text()
    centimetres = metres.replace("SI_UNIT( $, .METRE. )", "SI_UNIT( .CENTI., .METRE. )")
    assert trimtess.read(metres.encode()).millimetres_per_unit == 1000
    assert trimtess.read(centimetres.encode()).millimetres_per_unit == 10
    sizes = [trimtess.read(text.encode()).prepare().diagonal for text in (metres, centimetres)]
    assert np.isclose(sizes[0], 100 * sizes[1])


def test_diagnostics_are_data():
    broken = SMALL.read_text().replace("CYLINDRICAL_SURFACE(", "CYLINDRICAL_SURFAC(")
    prepared = trimtess.read(broken.encode()).prepare()
    told = [told for told in prepared.diagnostics if told.face is not None][0]
    assert told.severity == "warning" and told.is_fault and told.entity == 54 and "#103" in told.message
    assert told.code in repr(told) and told.message in repr(told) and f"face={told.face}" in repr(told)
    mesh = prepared.tessellate()
    assert mesh.status == 3 and told.code in {told.code for told in mesh.diagnostics if told.is_fault}
    assert trimtess.read(SMALL).prepare().tessellate().status == 0

    no_unit = SMALL.read_text().replace("GLOBAL_UNIT_ASSIGNED_CONTEXT(", "GLOBAL_UNIT(")
    codes = {told.code: told for told in trimtess.read(no_unit.encode()).diagnostics}
    assert codes["step-no-unit"].severity == "warning" and not codes["step-no-unit"].is_fault


def test_supplemental_geometry_is_read_if_asked_for():
    counts = [trimtess.read(LARGE, supplemental=told).face_count for told in (False, True)]
    assert counts[0] <= counts[1]


def test_representations_name_the_facts(prepared):
    model, mesh = trimtess.read(SMALL), prepared.tessellate()
    assert "2 parts" in repr(prepared) or "parts" in repr(prepared)
    for shown in (model, prepared, mesh):
        table = shown._repr_html_()
        assert table.startswith("<table>") and "diagnostics" in table
    assert str(mesh.triangle_count) in repr(mesh) and str(mesh.triangle_count) in mesh._repr_html_()


def test_names_are_escaped_in_tables():
    model = trimtess.read(SMALL.read_bytes(), name="<script>")
    assert "<script>" not in model._repr_html_() and "&lt;script&gt;" in model._repr_html_()


@pytest.mark.parametrize("source", [7, None, ["x"]])
def test_other_sources_are_wrong_types(source):
    with pytest.raises(TypeError):
        trimtess.read(source)
