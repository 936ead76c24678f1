"""Pictures, where there is a graphics adapter."""

import numpy as np
import pytest
from files import LARGE

import trimtess


@pytest.fixture(scope="module")
def picture(prepared):
    try:
        return prepared.render(320, 240)
    except trimtess.NoAdapterError as error:
        pytest.skip(str(error))


def test_a_picture_is_an_array_of_bytes(picture):
    assert picture.shape == (240, 320, 4) and picture.dtype == np.uint8 and not picture.flags.writeable
    assert (picture[..., 3] == 255).all()


def test_colours_of_the_model_are_in_the_picture(picture):
    red, green, blue = (picture[..., k].astype(int) for k in range(3))
    assert (red - np.maximum(green, blue) > 60).sum() > 500, "the red cube"
    assert (blue - np.maximum(red, green) > 60).sum() > 500, "the blue cylinder"


def test_views_and_colours_change_the_picture(prepared, picture):
    views = [{"view": "top"}, {"view": "30,20,1.5"}, {"orthographic": True}]
    for arguments in [*views, {"color_by": "face"}, {"edges": True}, {"wireframe": True}]:
        assert not np.array_equal(prepared.render(320, 240, **arguments), picture), arguments


def test_notebooks_show_a_png(prepared, picture):
    for shown in (prepared, prepared.tessellate()):
        assert shown._repr_png_().startswith(b"\x89PNG")


def test_a_limit_names_no_argument_that_render_lacks(picture):
    large = trimtess.read(LARGE, max_memory=60 * LARGE.stat().st_size).prepare()
    with pytest.raises(trimtess.LimitError, match="use a larger deviation_px or size_px") as told:
        large.render(320, 240, deviation_px=1e-5)
    assert told.value.name is None and told.value.needed > told.value.limit


@pytest.mark.parametrize(
    "arguments, name",
    [
        ({"width": 0}, "width"),
        ({"height": 40_000}, "height"),
        ({"view": "nowhere"}, "view"),
        ({"color_by": "mood"}, "color_by"),
        ({"deviation_px": 0}, "deviation_px"),
    ],
)
def test_options_out_of_range_are_refused(prepared, arguments, name):
    with pytest.raises(trimtess.RangeError) as told:
        prepared.render(**arguments)
    assert told.value.name == name
