"""The relief as a solid: closed, of the right volume, and an OpenSCAD source that says the same."""

from __future__ import annotations

import re

import numpy as np
import pytest
from shapely import Polygon

from pinchoff.chamber import write_scad, write_stl
from pinchoff.chamber.layout import REGIONS


def read_stl(path):
    data = path.read_bytes()
    count = int(np.frombuffer(data, "<u4", 1, 80)[0])
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    assert len(data) == 84 + count * record.itemsize
    return np.frombuffer(data, record, count, 84)


def test_the_stl_is_closed_and_holds_the_fluids_volume(tmp_path, small):
    write_stl(small, tmp_path / "chamber.stl")
    triangles = read_stl(tmp_path / "chamber.stl")
    corners = triangles["corners"].astype(np.float64)
    # Closed: every directed edge has its counterpart.
    edges = corners[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 6)
    turned = edges[:, [3, 4, 5, 0, 1, 2]]
    assert sorted(map(tuple, edges)) == sorted(map(tuple, turned))
    # Divergence theorem; it comes out positive if the normals point outwards.
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    wanted = small.layout.fluid.area * small.thickness_um * 1e-9  # mm³
    assert volume == pytest.approx(wanted, rel=1e-6)
    assert np.ptp(corners[:, :, 2]) == pytest.approx(small.thickness_um * 1e-3)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    cosine = np.sum(normal * triangles["normal"], axis=1) / np.linalg.norm(normal, axis=1)
    assert cosine.min() > 0.999


@pytest.fixture
def scad(tmp_path, small):
    write_scad(small, tmp_path / "chamber.scad")
    return (tmp_path / "chamber.scad").read_text(encoding="utf-8")


def test_the_scad_source_is_balanced_and_defines_what_it_uses(scad):
    code = re.sub(r"//[^\n]*", "", scad)
    for opening, closing in ("()", "[]", "{}"):
        depth = np.cumsum([(c == opening) - (c == closing) for c in code])
        assert depth.min() >= 0
        assert depth[-1] == 0
    modules = set(re.findall(r"module (\w+)\(", code))
    assert modules >= {*REGIONS, "relief", "mould", "device"}
    built_in = {
        *("polygon", "circle", "square", "translate", "difference", "linear_extrude", "color"),
        "for",
    }
    assert set(re.findall(r"(\w+)\s*\(", code)) <= modules | built_in | {"if"}
    assert "nan" not in code


def test_the_scad_source_has_the_designs_area_and_height(scad, small):
    assert float(re.search(r"^z = ([\d.]+);", scad, re.M)[1]) == small.thickness_um * 1e-3
    for name in REGIONS:
        body = re.search(rf"module {name}\(\) {{(.*?)\n}}", scad, re.S)[1]
        points = np.array(eval(re.search(r"points = (\[.*?\]\])", body)[1]))
        paths = eval(re.search(r"paths = (\[.*\]\])", body)[1])
        area = sum(Polygon(points[path]).area for path in paths) * 1e6
        assert area == pytest.approx(small.layout.walls[name].area, rel=1e-6), name
        wanted = [p for p in small.layout.pillars if p.region == name]
        listed = re.search(rf"^{name}_pillars = (\[.*\]);", scad, re.M)
        places = eval(listed[1]) if listed else []
        assert places == [[p.x_um / 1e3, p.y_um / 1e3] for p in wanted]
