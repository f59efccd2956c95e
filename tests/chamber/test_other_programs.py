"""The device as KLayout and OpenSCAD read it."""

from __future__ import annotations

import shutil
import subprocess

import numpy as np
import pytest

from pinchoff.chamber import Chamber, check_rules, write_dxf, write_gds, write_scad, write_stl
from pinchoff.chamber.masks import LAYERS, layers

db = pytest.importorskip("klayout.db", reason="KLayout's Python package is not installed")

WRITERS = {"gds": write_gds, "dxf": write_dxf}
PROGRAM = shutil.which("openscad")
needs_openscad = pytest.mark.skipif(PROGRAM is None, reason="OpenSCAD is not installed")


def read_regions(path):
    """Read a mask as KLayout does when nothing is set; return the merged polygons of each layer."""
    layout = db.Layout()
    layout.read(str(path))
    names = {number: name for name, number in LAYERS.items()}
    regions = {}
    for index in layout.layer_indexes():
        info = layout.get_info(index)
        region = db.Region(layout.top_cell().begin_shapes_rec(index)).merged()
        regions[info.name or names[info.layer]] = region
    return regions, layout.dbu


@pytest.mark.parametrize("kind", WRITERS)
@pytest.mark.parametrize("polarity", ["dark-field", "bright-field"])
def test_klayout_reads_every_layer_as_it_was_drawn(tmp_path, kind, polarity):
    chamber = Chamber(mask={"polarity": polarity})
    WRITERS[kind](chamber, tmp_path / f"mask.{kind}")
    regions, dbu = read_regions(tmp_path / f"mask.{kind}")
    drawn = layers(chamber)
    for name, shape in drawn.items():
        assert regions[name].area() * dbu**2 == pytest.approx(shape.area, rel=1e-6), name
    pillars, clear = regions["pillars"], regions["mask_clear"]
    assert pillars.count() == len(chamber.layout.pillars)
    if polarity == "bright-field":
        assert (pillars - clear).area() * dbu**2 < 1e-6 * drawn["pillars"].area
    else:
        assert (pillars & clear).area() * dbu**2 < 1e-6 * drawn["pillars"].area


@pytest.mark.parametrize("settings", [{}, {"oil_inputs": {"channel_width_um": 150}}])
def test_klayouts_checks_find_what_ours_find(tmp_path, settings):
    chamber = Chamber(**settings)
    assert check_rules(chamber) == []
    write_gds(chamber, tmp_path / "mask.gds")
    regions, dbu = read_regions(tmp_path / "mask.gds")
    for least, check in (
        (chamber.rules.least_gap_um, regions["mask_clear"].width_check),
        (chamber.rules.least_wall_um, regions["mask_clear"].space_check),
    ):
        assert check(round(least / dbu)).count() == 0


def test_the_check_that_finds_nothing_would_find_a_sharp_wedge(tmp_path):
    sharp = db.Region(db.Polygon([db.Point(0, 0), db.Point(90000, 0), db.Point(0, 80000)]))
    assert sharp.width_check(15000).count() > 0


def sections_area(path):
    """Return the area of a prism's section: that of its faces that look up."""
    words = path.read_text().split()
    corners = np.array(
        [words[k + 1 : k + 4] for k, word in enumerate(words) if word == "vertex"], dtype=float
    ).reshape(-1, 3, 3)
    flat = np.ptp(corners[:, :, 2], axis=1) == 0.0
    a, b = corners[flat, 1] - corners[flat, 0], corners[flat, 2] - corners[flat, 0]
    area = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
    return area[area > 0.0].sum(), np.ptp(corners[:, :, 2])


def rendered(source, target, show):
    command = [PROGRAM, "-D", f'show="{show}"', "-o", str(target), str(source)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=900)
    assert done.returncode == 0, done.stderr
    assert "WARNING" not in done.stderr
    assert "ERROR" not in done.stderr
    return done.stderr


@needs_openscad
def test_openscad_builds_the_section_of_the_stl(tmp_path, paper):
    write_scad(paper, tmp_path / "mould.scad")
    write_stl(paper, tmp_path / "mould.stl")
    rendered(tmp_path / "mould.scad", tmp_path / "relief.stl", "relief")
    area, height = sections_area(tmp_path / "relief.stl")
    # It joins plane shapes on a grid of 2⁻¹⁶ mm, 15 nm.
    assert area == pytest.approx(paper.layout.fluid.area * 1e-6, rel=1e-5)
    assert height == pytest.approx(paper.thickness_um * 1e-3)


@pytest.mark.slow
@needs_openscad
@pytest.mark.parametrize("show", ["mould", "device"])
def test_openscad_builds_one_solid(tmp_path, paper, show):
    write_scad(paper, tmp_path / "mould.scad")
    said = rendered(tmp_path / "mould.scad", tmp_path / "solid.stl", show)
    assert "Simple:        yes" in said
    assert "Volumes:         2" in said  # of CGAL: outside and one solid
