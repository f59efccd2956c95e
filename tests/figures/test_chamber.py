"""Figures of the device show what the design holds."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from matplotlib.colors import to_rgb
from matplotlib.image import imread
from matplotlib.patches import Circle

pytest.importorskip("gdstk", reason="the extra 'chamber' is not installed")

from pinchoff.chamber import Chamber, check_rules
from pinchoff.chamber.rules import broken_rules
from pinchoff.figures import style
from pinchoff.figures.chamber_design import REGION_LOOK, chamber_design


@pytest.fixture(scope="module")
def chamber():
    return Chamber()


@pytest.fixture(scope="module")
def picture(chamber, tmp_path_factory):
    """The picture, and a function from the design's mm to its row and column."""
    path = tmp_path_factory.mktemp("chamber") / "chamber.png"
    axes = chamber_design(chamber)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(style, "DOTS_PER_INCH", axes.figure.dpi)  # a dot for each pixel of the axes
        style.save(path, axes)
    pixels = imread(path)[..., :3]

    def at(x_um, y_um):
        column, row = axes.transData.transform((x_um / 1e3, y_um / 1e3))
        return pixels[len(pixels) - 1 - round(row), round(column)]

    return at


def test_each_region_has_its_colour_and_pillars_are_white(chamber, picture):
    for name, shape in chamber.layout.regions.items():
        # 60 µm inside the outline of the largest part: away from rims and numbers.
        inner = shapely.get_parts(shape.buffer(-60))
        part = max(inner, key=lambda each: each.area)
        place = part.exterior.interpolate(0.4, normalized=True)
        np.testing.assert_allclose(
            picture(place.x, place.y), to_rgb(REGION_LOOK[name][0]), atol=0.02
        )
    for pillar in (p for p in chamber.layout.pillars if p.region in ("imaging", "supports")):
        np.testing.assert_allclose(picture(pillar.x_um, pillar.y_um), 1.0, atol=0.02)


def test_regions_are_numbered_and_named(chamber):
    axes = chamber_design(chamber)
    assert sorted(text.get_text() for text in axes.texts) == list("1234567")
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels[5] == "6  imaging area"


def test_violations_are_marked_where_they_are():
    chamber = Chamber(rules={"on_violation": "warn"}, oil_inputs={"channel_width_um": 15})
    violations = check_rules(chamber)
    axes = chamber_design(chamber, violations)
    rings = [patch.center for patch in axes.patches if isinstance(patch, Circle)]
    assert rings == [(each.x_um / 1e3, each.y_um / 1e3) for each in violations]
    rules = broken_rules(violations)
    assert {text.get_text() for text in axes.texts} == {str(k + 1) for k in range(len(rules))}
    for line in rules:
        assert line in axes.get_title(loc="left")
