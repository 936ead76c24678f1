"""Errors are exceptions with fields; no panic crosses the interface."""

import functools
import pickle

import pytest
from files import LARGE, SHARED, SMALL

import trimtess

CLASSES = [
    trimtess.ReadError("m", kind="io", path="p", errno=2, strerror="s"),
    trimtess.LimitError("m", name="max_memory", limit=3),
    trimtess.RangeError("m", name="chord", value="-1", expected="a number"),
    trimtess.LimitError("m", name=None, limit=3, needed=4),
    trimtess.TessellateError("m"),
    trimtess.FormatError("m", extension="x"),
    trimtess.SaveError("m", path="p", errno=28, strerror="s"),
    trimtess.RoundingError("m", path="p", moved=1.0, allowed=0.5, place=(1, 2, 3), recenter_helps=True),
    trimtess.NoAdapterError("m"),
    trimtess.InternalError("m"),
]


@pytest.mark.parametrize("error", CLASSES, ids=lambda error: type(error).__name__)
def test_exceptions_survive_pickling_with_their_fields(error):
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error) and str(again) == str(error) == "m"
    assert again.__dict__ == error.__dict__
    assert getattr(again, "errno", None) == getattr(error, "errno", None)
    assert isinstance(error, trimtess.Error)


def test_a_missing_file_is_an_os_error_with_its_number(tmp_path):
    with pytest.raises(OSError) as told:
        trimtess.read(tmp_path / "none.step")
    error = told.value
    assert isinstance(error, trimtess.ReadError)
    assert (error.kind, error.errno, error.filename) == ("io", 2, str(tmp_path / "none.step"))
    assert "none.step" in str(error)


@pytest.mark.parametrize(
    "content, kind",
    [(b"", "not-step"), (b"%PDF-1.7 and more", "not-step"), (b"\x7fELF" + bytes(99), "not-step")],
)
def test_other_files_are_refused_by_kind(content, kind, tmp_path):
    path = tmp_path / "x.step"
    path.write_bytes(content)
    for source in (path, content):
        with pytest.raises(trimtess.ReadError) as told:
            trimtess.read(source)
        assert told.value.kind == kind and told.value.errno is None
        assert told.value.path == (str(path) if source is path else None)


@pytest.mark.parametrize(
    "arguments, name",
    [({"max_bytes": 100}, "max_bytes"), ({"max_memory": 1000}, "max_memory"), ({"max_entities": 3}, "max_entities")],
)
def test_limits_of_reading_name_the_argument_and_the_numbers(arguments, name):
    with pytest.raises(trimtess.LimitError) as told:
        trimtess.read(SMALL, **arguments)
    error = told.value
    assert error.name == name and error.limit == arguments[name] and error.needed > error.limit
    assert name in str(error)


def test_limits_of_preparing_and_tessellating_name_the_argument(large):
    model = trimtess.read(LARGE)
    for arguments, name in [({"max_patches": 3}, "max_patches"), ({"max_memory": 10_000}, "max_memory")]:
        with pytest.raises(trimtess.LimitError) as told:
            model.prepare(**arguments)
        assert told.value.name == name and told.value.limit == arguments[name]
    with pytest.raises(trimtess.LimitError) as told:
        large.tessellate(max_triangles=1000)
    assert (told.value.name, told.value.limit) == ("max_triangles", 1000) and told.value.needed > 1000
    assert str(told.value).endswith("; use a larger tolerance, a larger max_triangles, or coarsen=True")
    mesh = large.tessellate(max_triangles=1000, coarsen=True)
    assert mesh.shortfall and large.tessellate().shortfall is None


def test_a_limit_that_no_argument_raises_names_none():
    rows = [
        "#1=(GEOMETRIC_REPRESENTATION_CONTEXT(3)REPRESENTATION_CONTEXT('',''))",
        "#20=AXIS2_PLACEMENT_3D('',#21,$,$)",
        "#21=CARTESIAN_POINT('',(0.,0.,0.))",
        "#62=ADVANCED_FACE('',(),#63,.T.)",
        "#63=SPHERICAL_SURFACE('',#20,1.)",
        "#64=OPEN_SHELL('',(#62))",
        "#65=SHELL_BASED_SURFACE_MODEL('',(#64))",
        "#66=MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',(#65),#1)",
    ]
    below = 66
    for row in range(200, 300, 5):
        # Each places the one before twice.
        rows += [f"#{row}=REPRESENTATION_MAP(#20,#{below})", f"#{row + 1}=MAPPED_ITEM('',#{row},#20)"]
        rows += [f"#{row + 2}=MAPPED_ITEM('',#{row},#20)"]
        rows += [f"#{row + 3}=SHAPE_REPRESENTATION('',(#{row + 1},#{row + 2}),#1)"]
        below = row + 3
    head = "ISO-10303-21;HEADER;FILE_DESCRIPTION((''),'2;1');FILE_NAME('','',(''),(''),'','','');"
    text = f"{head}FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));ENDSEC;DATA;{';'.join(rows)};ENDSEC;END-ISO-10303-21;"
    with pytest.raises(trimtess.LimitError, match="assemblies nested in each other") as told:
        trimtess.read(text.encode())
    assert told.value.name is None and told.value.needed is None and told.value.limit > 30_000


def test_more_threads_than_any_machine_has_are_refused(large):
    read = functools.partial(trimtess.read, SMALL)
    for call in [read, read().prepare, large.tessellate, large.session, large.render]:
        with pytest.raises(trimtess.RangeError, match="workers is 1025"):
            call(workers=1025)


def test_the_memory_limit_of_reading_holds_for_later_stages():
    size = LARGE.stat().st_size
    prepared = trimtess.read(LARGE, max_memory=60 * size).prepare()
    with pytest.raises(trimtess.LimitError) as told:
        prepared.tessellate(chord_rel=1e-7)
    assert told.value.name == "max_memory"
    assert told.value.limit == 60 * size < told.value.needed
    # The prepared model leaves room for fewer triangles than the limit on these.
    with pytest.raises(trimtess.LimitError) as told:
        prepared.tessellate(chord_rel=1e-3, max_triangles=10_000_000, max_memory=1 << 20)
    assert (told.value.name, told.value.limit) == ("max_memory", 1 << 20)


@pytest.mark.parametrize(
    "arguments",
    [{"chord": 0}, {"chord": -1}, {"chord": float("nan")}, {"chord_rel": float("inf")}, {"angle": 0}, {"max_edge": -2}],
)
def test_tolerances_out_of_range_are_value_errors(prepared, arguments):
    with pytest.raises(trimtess.RangeError) as told:
        prepared.tessellate(**arguments)
    assert told.value.name in arguments and isinstance(told.value, ValueError)


def test_two_chords_are_one_too_many(prepared):
    with pytest.raises(trimtess.RangeError):
        prepared.tessellate(chord=1, chord_rel=1e-3)


def test_tolerances_too_small_to_meet_are_refused(prepared):
    with pytest.raises(trimtess.Error):
        prepared.tessellate(chord=1e-300)


def test_cut_files_never_do_more_than_raise():
    text = SMALL.read_bytes()
    for cut in range(0, len(text), len(text) // 40):
        try:
            mesh = trimtess.read(text[:cut], workers=1).prepare(workers=1).tessellate(workers=1)
        except trimtess.Error:
            continue
        assert mesh.status in (0, 3)


def test_attacks_are_refused_or_told(tmp_path):
    files = sorted((SHARED / "attack").glob("*.step"))
    if not files:
        pytest.skip(f"{SHARED} has no folder attack")
    for file in files:
        try:
            mesh = trimtess.read(file, max_memory=500 << 20).prepare().tessellate()
            mesh.save(tmp_path / "x.stl")
        except trimtess.Error as error:
            assert str(error), file
