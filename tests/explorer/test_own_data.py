"""A user's own collisions in the page: what is taken, what is left out, what is text."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff import Parameters, _core
from pinchoff.cli import main
from pinchoff.collisions.parquet import write_collisions
from pinchoff.explorer import films, own_data
from pinchoff.explorer.page import explorer_page
from pinchoff.model.outlines import Outlines

if TYPE_CHECKING:
    from conftest import Opened

Open = Callable[..., "Opened"]
EVIL = '<script>alert("x")</script><img src=x onerror=alert(1)>'


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    several = [
        Parameters(offset=y, simulation_capillary_number=ca, vertex_count=32)
        for ca in (15.0, 40.0)
        for y in (0.02, 0.2)
    ]
    return po.simulate_many(several, progress=False)


@pytest.fixture(scope="module")
def mine(table: pd.DataFrame, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("table") / "mine.parquet"
    write_collisions(table, path)
    return path


def test_a_table_of_ours_is_taken_as_it_stands(table: pd.DataFrame, mine: Path) -> None:
    own = own_data.own_data(mine)
    assert own["title"] == "mine.parquet"
    assert own["words"] == []
    assert own["values"]["broke"] == [bool(b) for b in table["broke"]]
    np.testing.assert_allclose(own["values"]["symmetry"], table["symmetry"], rtol=1e-5)
    units = {column["name"]: column["unit"] for column in own["columns"]}
    assert units["offset"] == "D0"
    json.dumps(own, allow_nan=False)


def test_what_is_not_measured_is_not_a_number(table: pd.DataFrame, mine: Path) -> None:
    own = own_data.own_data(mine)
    unbroken = [k for k, broke in enumerate(table["broke"]) if not broke]
    assert unbroken
    assert all(own["values"]["daughter_area_ratio"][k] is None for k in unbroken)
    assert "area_um2" not in own["values"], "a column without any value is left out"


def test_a_foreign_table_keeps_its_own_columns_and_says_what_is_lost(tmp_path: Path) -> None:
    rows = pd.DataFrame(
        {
            "S_meas": [0.5, 0.8, 7.0, 0.2],
            "capillary_number": [0.002, 0.003, 0.004, 0.005],
            "normalized_area": 25.0,
            "normalized_thickness": 1.0,
            "broke": ["no", "yes", "yes", "no"],
            "chip": ["a", EVIL, "a", "b"],
        }
    )
    rows.to_csv(tmp_path / "mine.csv", index=False)
    own = own_data.own_data(tmp_path / "mine.csv", columns={"symmetry": "S_meas"})
    assert own["values"]["symmetry"] == [0.5, 0.8, 0.2]
    assert own["values"]["chip"] == ["a", EVIL, "b"]
    assert "1 of 4 rows are set aside" in own["words"][0]


def test_too_many_rows_are_thinned_with_a_word(mine: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(own_data, "MOST_ROWS", 3)
    own = own_data.own_data(mine)
    assert len(own["values"]["symmetry"]) == 3
    assert own["words"] == ["3 of 4 rows, evenly taken, are in this page"]


def unpacked(film: dict) -> list[list[np.ndarray]]:
    numbers = np.frombuffer(base64.b64decode(film["vertices"]), "<i2").reshape(-1, 2)
    frames, at = [], 0
    for counts in film["counts"]:
        frames.append([])
        for count in counts:
            frames[-1].append(numbers[at : at + count] * film["unit"])
            at += count
    assert at == len(numbers)
    return frames


def test_a_run_brings_its_outlines(tmp_path: Path) -> None:
    assert main(["run", "--out", str(tmp_path / "one"), "--set", "vertex_count=40"]) == 0
    own = own_data.own_data(tmp_path / "one")
    film = own["films"][0]
    outlines = Outlines.load(tmp_path / "one" / "outlines.gsd")
    assert len(film["times"]) <= films.MOST_FRAMES
    contact = json.loads((tmp_path / "one" / "collision.json").read_text())["results"]
    first = np.searchsorted(outlines.times, film["times"][0] + contact["contact_time"] - 1e-6)
    shown = unpacked(film)[0][0]
    np.testing.assert_allclose(shown, outlines[int(first)][0].vertices, atol=film["unit"])


DIAMETER_UM, SPEED_MM_S, PLACE_UM, ANGLE = 481.0, 1.2, np.array([900.0, 700.0]), 0.5


def in_image(points: np.ndarray) -> np.ndarray:
    """Turn a run's points into those of an image: flow at an angle, y down, mirrored."""
    x, y = points.T * DIAMETER_UM
    cosine, sine = np.cos(ANGLE), np.sin(ANGLE)
    # On the right of the flow as one looks along it, which the page mirrors back.
    return np.column_stack([cosine * x - sine * y, sine * x + cosine * y])


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `pinchoff video` writes of one collision whose outlines are those of a run."""
    pytest.importorskip("cv2", reason="pinchoff[video] is not installed")
    from pinchoff.video import clip_folder
    from pinchoff.video.batch import CLIPS
    from pinchoff.video.encounters import Encounter, Laboratory, encounter_table, write_encounters

    run = po.simulate(
        Parameters(offset=0.08, simulation_capillary_number=40, vertex_count=48), outlines=0.02
    )
    outlines, contact = run.outlines, run.contacts[0]
    assert outlines is not None
    unit_s = DIAMETER_UM * 1e-3 / SPEED_MM_S
    radius_um = run.parameters.obstacle_radius * DIAMETER_UM
    frames = [
        [(k, 0, in_image(o.vertices) + PLACE_UM, o.velocities) for k, o in enumerate(droplets)]
        for droplets in outlines
    ]
    folder = tmp_path_factory.mktemp("film") / "measured"
    clip = folder / CLIPS / "<b>clip"
    (clip / clip_folder.THUMBNAILS).mkdir(parents=True)
    Outlines.from_frames(
        outlines.times * unit_s, frames, [[*PLACE_UM, radius_um]], {}, units="um"
    ).save(clip / clip_folder.OUTLINES)
    at_contact = int(np.searchsorted(outlines.times, contact["time"]))
    velocity = in_image(np.array([[contact["velocity_x"], contact["velocity_y"]]]))[0]
    encounter = Encounter(
        obstacle=(*PLACE_UM, radius_um),
        outline=frames[at_contact][0][2][::-1],
        velocity=tuple(velocity / np.hypot(*velocity) * SPEED_MM_S),
        contact_frame=at_contact,
        end_frame=len(outlines),
        contact_time_s=contact["time"] * unit_s,
        outcome="broke",
        breakup_time_s=run.breakup_time * unit_s,
    )
    laboratory = Laboratory(
        obstacle_radius_um=radius_um,
        thickness_um=radius_um,
        viscosity_mPa_s=48.0,
        surface_tension_mN_m=20.0,
    )
    table = encounter_table([encounter], laboratory, "video", "<b>clip")
    write_encounters(table, folder / own_data.TABLE)
    name = clip_folder.thumbnail_name(at_contact, 0, 0)
    clip_folder.cv2.imwrite(str(clip / clip_folder.THUMBNAILS / name), np.zeros((40, 60, 3)))
    return folder


def test_a_film_is_turned_into_the_flow_and_scaled(measured: Path) -> None:
    own = own_data.own_data(measured)
    [row] = own["films"]
    film = own["films"][row]
    assert own["thumbnails"][row].startswith("data:image/jpeg;base64,")
    contact = int(np.argmin(np.abs(film["times"])))
    [outline] = unpacked(film)[contact]
    # The droplet is upstream of the pillar, above its centre, of unit diameter, and just touches.
    assert _core.centroid(outline)[0] < 0
    assert _core.centroid(outline)[1] > 0
    assert abs(_core.area(outline)) == pytest.approx(np.pi / 4, rel=0.03)
    gap = np.hypot(*outline.T).min() - film["radius"]
    assert -0.05 < gap < 0.15
    symmetry = _core.symmetry(outline[:: np.sign(_core.area(outline)).astype(int)], (0, 0), (1, 0))
    assert symmetry == pytest.approx(own["values"]["symmetry"][row], abs=0.05)
    assert film["times"] == sorted(film["times"])
    assert len(unpacked(film)[-1]) == 2, "both daughters are shown"


def test_a_measured_collision_is_simulated_beside_its_film(opened: Open, measured: Path) -> None:
    page = opened(own_data.own_data(measured))
    page.page.evaluate("explorer.own.choose(0)")
    page.until("Math.abs(explorer.state.values.size_ratio - 5.66) > 1e-6")
    page.settled()
    page.until("explorer.current().run.result.symmetry > 0")
    row = page.value(
        "Object.fromEntries(Object.entries(explorer.own.payload.values)"
        ".map(([name, all]) => [name, all[0]]))"
    )
    result = page.value("explorer.current().run.result")
    assert result["symmetry"] == pytest.approx(row["symmetry"], abs=0.01)
    values = page.value("explorer.state.values")
    assert values["size_ratio"] == pytest.approx(row["size_ratio"], rel=1e-5)
    p = Parameters(simulation_capillary_number=values["simulation_capillary_number"])
    assert p.capillary_number == pytest.approx(row["capillary_number"], rel=1e-4)
    assert page.page.locator("#measured").is_visible()
    assert page.page.locator("#own-one img").is_visible()
    assert "<b>clip" in page.page.inner_text("#own-one")


@pytest.mark.parametrize(("per", "expected"), [(2e-4, 50.0), (None, 0.01 / 9.8e-5)])
def test_ca_is_turned_into_ca_sim_as_the_table_says(
    opened: Open, tmp_path: Path, per: float | None, expected: float
) -> None:
    """Tables of simulations say what Ca stands for; without that it is the default's."""
    rows = {"symmetry": 0.5, "capillary_number": 0.01, "normalized_area": 25.0, "broke": True}
    rows |= {"normalized_thickness": 1.0} | ({} if per is None else {"ca_per_ca_sim": per})
    pd.DataFrame([rows]).to_csv(tmp_path / "mine.csv", index=False)
    page = opened(own_data.own_data(tmp_path / "mine.csv"))
    page.page.evaluate("explorer.own.choose(0)")
    page.until("explorer.state.values.simulation_capillary_number !== 25")
    found = page.value("explorer.state.values.simulation_capillary_number")
    assert found == pytest.approx(expected, rel=1e-5)


def test_names_from_files_are_text(opened: Open, tmp_path: Path) -> None:
    rows = pd.DataFrame(
        {
            "symmetry": [0.5, 0.8],
            "capillary_number": [0.002, 0.003],
            "normalized_area": 25.0,
            "normalized_thickness": 1.0,
            "broke": [False, True],
            EVIL: ["a", EVIL],
        }
    )
    path = tmp_path / "evil<script>.csv"
    rows.to_csv(path, index=False)
    own = own_data.own_data(path)
    assert "<script>alert" not in explorer_page(own)
    page = opened(own)
    assert "evil<script>.csv" in page.page.inner_text("#own-title")
    page.page.select_option("#own-filters > select", EVIL)
    assert EVIL in page.page.locator("#own-filters legend").text_content()
    page.page.evaluate("explorer.own.choose(1)")
    page.settled()
    assert page.page.locator("img").count() == 0
    assert page.value("document.scripts.length") == 5


def test_points_are_filtered_by_columns(opened: Open, table: pd.DataFrame, mine: Path) -> None:
    page = opened(own_data.own_data(mine))
    assert page.value("explorer.own.points.length") == 4
    page.page.select_option("#own-filters > select", "simulation_capillary_number")
    page.page.locator("#own-filters input").nth(0).fill("20")
    assert page.value("explorer.own.points.length") == 2
    assert page.page.inner_text("#own-word").startswith("2 of 4 collisions")
    page.page.select_option("#own-filters > select", "outcome")
    page.page.locator("#own-filters fieldset select").select_option("broke")
    broke = int((table["broke"] & (table["simulation_capillary_number"] > 20)).sum())
    assert page.value("explorer.own.points.length") == broke
    page.page.locator("#own-filters fieldset button").nth(0).click()
    assert page.value("explorer.own.points.length") == int(table["broke"].sum())


def test_a_row_without_its_groups_says_why_it_is_not_simulated(opened: Open) -> None:
    own = {
        "title": "t",
        "words": [],
        "columns": [{"name": "symmetry", "unit": "1", "meaning": "", "kind": "number"}],
        "values": {"symmetry": [0.5]},
        "films": {},
        "thumbnails": {},
        "lines": [],
    }
    page = opened(own)
    assert "1 without a place in the diagram" in page.page.inner_text("#own-word")
    page.page.evaluate("explorer.own.choose(0)")
    assert "size_ratio and simulation_capillary_number not known" in page.page.inner_text(
        "#own-one"
    )
    assert page.page.locator("#own-one button").is_disabled()
