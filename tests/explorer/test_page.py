"""The page in a browser: everything that its users do, with nothing asked of the network."""

from __future__ import annotations

import csv
import io
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import pinchoff as po
from pinchoff import Parameters
from pinchoff.collisions.importing import import_collisions

if TYPE_CHECKING:
    from conftest import Opened

Open = Callable[..., "Opened"]


def run_of(opened: Opened) -> dict[str, float]:
    """Return the results of the collision that is shown."""
    opened.settled()
    return dict(opened.value("explorer.current().run.result"))


def test_the_page_shows_the_run_of_python(opened: Open) -> None:
    page = opened()
    result = run_of(page)
    expected = po.simulate(Parameters())
    assert result["symmetry"] == pytest.approx(expected.symmetry, abs=1e-12)
    assert result["breakup_time"] == pytest.approx(expected.breakup_time, abs=1e-9)
    assert page.page.inner_text("#outcome") == "breaks"
    numbers = page.page.inner_text("#numbers")
    assert f"{expected.symmetry:.3g}" in numbers
    assert f"{expected.daughter_area_ratio:.3g}" in numbers


def test_rows_made_in_the_page_are_those_made_in_python(opened: Open) -> None:
    page = opened()
    random = np.random.default_rng(7)
    several: list[dict[str, Any]] = [{}]
    for _ in range(100):
        several.append(
            {
                "size_ratio": random.uniform(0.5, 20),
                "simulation_capillary_number": 10 ** random.uniform(-1, 3),
                "offset": random.uniform(-1, 1),
                "vertex_count": int(random.integers(24, 200)),
                "line_tension": 10 ** random.uniform(0, 3),
                "edge_stiffness": 10 ** random.uniform(-2, 2),
                "neck_separation_unit": str(random.choice(["perimeter", "diameter"])),
                "follow_daughters": bool(random.integers(2)),
                "model": "deformable-particle",
                **({"area_stiffness": 10 ** random.uniform(3, 6)} if random.integers(2) else {}),
            }
        )
    springs = ("line_tension", "edge_stiffness", "area_stiffness", "wall_stiffness")
    several += [
        {**{n: v for n, v in values.items() if n not in springs}, "model": "front-tracking"}
        for values in several[1:30]
    ]
    several += [preset["constants"] for preset in page.value("explorer.facts.presets")]
    for values in several:
        row = page.page.evaluate(
            "values => Array.from(explorer.model.row({...explorer.model.defaults(), ...values}), "
            "x => Number.isNaN(x) ? null : x)",
            values,
        )
        expected = Parameters(**values).model_row()
        here = np.array([np.nan if x is None else x for x in row])
        automatic = np.isnan(here)
        assert automatic.sum() == ("time_step" not in values)
        np.testing.assert_array_equal(here[~automatic], expected[~automatic])


def test_the_model_is_chosen(opened: Open) -> None:
    page = opened()
    page.page.evaluate("explorer.set({line_tension: 60})")
    page.page.select_option("#model", "front-tracking")
    page.until("explorer.current().here?.values.model === 'front-tracking'")
    expected = po.simulate(Parameters(model="front-tracking"))
    result = run_of(page)
    assert result["symmetry"] == pytest.approx(expected.symmetry, abs=1e-12)
    assert result["breakup_time"] == pytest.approx(expected.breakup_time, abs=1e-9)
    command = page.page.inner_text("#command")
    assert "--model front-tracking" in command
    assert "line_tension" not in command, "it means nothing without springs"


def test_values_are_refused_as_in_python(opened: Open) -> None:
    page = opened()
    for name, value in (
        ("offset", 9),
        ("vertex_count", 15.5),
        ("line_tension", 0),
        ("time_step", 1),
    ):
        page.page.evaluate("([name, value]) => explorer.set({[name]: value})", [name, value])
        said = page.page.inner_text("#refusal")
        with pytest.raises(po.InputError) as error:
            Parameters(**{name: value})
        assert said.startswith(f"{name} must be {error.value.rule}; got {value}")
        page.page.evaluate("name => explorer.set({[name]: explorer.model.defaults()[name]})", name)
    page.page.evaluate("explorer.set({neck_thickness: 0.9})")
    page.until("explorer.current().refused !== ''")
    assert page.page.inner_text("#refusal").startswith("neck_thickness must be")


def test_the_droplet_is_dragged(opened: Open) -> None:
    page = opened()
    box = page.page.locator("#scene").bounding_box()
    handle = page.value(
        "(explorer.scene.handle - explorer.scene.view.left) * explorer.scene.view.scale"
    )
    scale = page.value("explorer.scene.view.scale")
    mouse = page.page.mouse
    y = box["y"] + box["height"] / 2 - 0.05 * scale
    mouse.move(box["x"] + handle, y)
    mouse.down()
    mouse.move(box["x"] + handle, y - 0.2 * scale, steps=5)
    mouse.up()
    assert page.value("explorer.state.values.offset") == pytest.approx(0.25, abs=0.01)
    page.settled()
    assert page.page.inner_text("#outcome") == "slips past"


def test_time_is_scrubbed_and_played(opened: Open) -> None:
    page = opened()
    page.page.locator("#scrub").focus()
    page.page.evaluate(
        "() => { const s = document.getElementById('scrub'); s.value = 2.5;"
        " s.dispatchEvent(new Event('input')); }"
    )
    assert page.value("explorer.state.time") == pytest.approx(2.5)
    page.page.locator("#marks button").first.click()
    contact = page.value("explorer.current().run.contacts[0].time")
    assert page.value("explorer.state.time") == pytest.approx(contact)
    page.page.locator("#scene").focus()
    page.page.keyboard.press("Space")
    page.until(f"explorer.state.time > {contact + 0.05}")
    page.page.keyboard.press("Space")
    assert page.value("explorer.state.playing") is False


def test_everything_works_with_the_keyboard(opened: Open) -> None:
    page = opened()
    page.page.locator("#scene").focus()
    page.page.keyboard.press("ArrowUp")
    assert page.value("explorer.state.values.offset") == pytest.approx(0.06)
    page.settled()
    page.page.keyboard.press("End")
    end = page.value("explorer.current().run.recording.times.at(-1)")
    assert page.value("explorer.state.time") == pytest.approx(end)
    before = page.value("explorer.state.values.simulation_capillary_number")
    page.page.locator("#diagram").focus()
    page.page.keyboard.press("ArrowRight")
    page.until(f"explorer.state.values.simulation_capillary_number > {before * 1.001}")
    page.settled()
    page.page.keyboard.press("n")
    page.settled()


def test_the_ring_in_the_diagram_sets_capillary_number_and_symmetry(opened: Open) -> None:
    page = opened()
    box = page.page.locator("#diagram").bounding_box()
    x, y = page.value("[explorer.diagram.X(0.1), explorer.diagram.Y(0.6)]")
    page.page.mouse.click(box["x"] + x, box["y"] + y)
    page.until("explorer.state.values.offset !== 0.05")
    result = run_of(page)
    assert result["symmetry"] == pytest.approx(0.6, abs=0.01)
    values = page.value("explorer.state.values")
    p = Parameters(**{k: values[k] for k in ("simulation_capillary_number", "offset")})
    assert p.capillary_number * p.normalized_area == pytest.approx(0.1, rel=0.02)


def test_a_slice_is_mapped_and_a_point_brought_back(opened: Open) -> None:
    page = opened()
    page.page.select_option("#map-size", "4")
    page.page.click("#map")
    page.until("document.getElementById('map-word').textContent.includes('16 collisions')")
    mapped = page.value("explorer.points.all.filter(p => p.small).map(p => [p.values, p.outcome])")
    assert len(mapped) == 16
    table = po.simulate_many(
        [Parameters(**{k: v for k, v in values.items() if v is not None}) for values, _ in mapped]
    )
    assert [outcome for _, outcome in mapped] == list(table["outcome"])
    box = page.page.locator("#diagram").bounding_box()
    spot = page.value(
        "(p => [explorer.diagram.X(p.strength), explorer.diagram.Y(p.symmetry), p.values.offset])"
        "(explorer.points.all.filter(p => p.small && p.symmetry > 0.3)[0])"
    )
    page.page.mouse.move(box["x"] + spot[0], box["y"] + spot[1])
    assert page.page.locator("#tip").is_visible()
    page.page.mouse.click(box["x"] + spot[0], box["y"] + spot[1])
    assert page.value("explorer.state.values.offset") == pytest.approx(spot[2])
    assert page.value("explorer.state.values.follow_daughters") is True


def test_a_map_can_be_cancelled(opened: Open) -> None:
    page = opened()
    page.page.select_option("#map-size", "40")
    page.page.click("#map")
    page.until("explorer.points.all.length > 3")
    page.page.click("#map")
    page.until("document.getElementById('map-word').textContent.startsWith('cancelled')")
    assert page.page.inner_text("#map") == "Map this slice"


def test_a_link_restores_the_page(opened: Open) -> None:
    page = opened()
    page.page.evaluate("explorer.set({offset: 0.11, vertex_count: 48, area_stiffness: 500000})")
    page.settled()
    page.page.click("#units")
    page.settled()
    page.page.locator("#log-symmetry").check()
    page.page.evaluate("explorer.goTo(1.75)")
    page.page.click("#copy-link")
    page.until("location.hash.includes('logS=1') && location.hash.includes('t=1.75')")
    before = page.value("[explorer.state.values, explorer.state.quantities]")
    again = opened(fragment=page.value("location.hash"))
    again.settled()
    assert again.value("[explorer.state.values, explorer.state.quantities]") == before
    assert again.value("explorer.state.time") == pytest.approx(1.75)
    assert again.page.locator("#log-symmetry").is_checked()
    again.until("explorer.points.all.length === 2")


def test_a_link_that_asks_for_the_impossible_is_told(opened: Open) -> None:
    page = opened(fragment="#offset=77&size_ratio=<img src=x>&tried=1_2~x_y_z")
    said = page.page.inner_text("#trouble")
    assert "offset must be" in said
    assert "2 points of the link" in said
    assert page.value("explorer.state.values.offset") == 0.05
    assert page.page.locator("img").count() == 0


def test_points_are_saved_as_a_table_that_pinchoff_reads(opened: Open, tmp_path: Path) -> None:
    page = opened()
    page.page.select_option("#map-size", "4")
    page.page.click("#map")
    page.until("document.getElementById('map-word').textContent.includes('16 collisions')")
    with page.page.expect_download() as download:
        page.page.click("#save-points")
    path = tmp_path / "collisions.csv"
    download.value.save_as(path)
    rows = list(csv.DictReader(io.StringIO(path.read_text(encoding="utf-8"))))
    assert len(rows) == 17
    touched = [row for row in rows if row["symmetry"]]
    table = import_collisions(path).table
    assert len(table) == len(touched)
    shown = po.breakup_number(
        table["capillary_number"],
        normalized_area=table["normalized_area"],
        symmetry=table["symmetry"],
    )
    np.testing.assert_allclose([float(row["breakup_number"]) for row in touched], shown, rtol=1e-12)


@pytest.mark.parametrize("button", ["#save-scene", "#save-diagram"])
def test_pictures_are_saved(opened: Open, tmp_path: Path, button: str) -> None:
    from matplotlib.image import imread

    page = opened()
    with page.page.expect_download() as download:
        page.page.click(button)
    path = tmp_path / "picture.png"
    download.value.save_as(path)
    pixels = imread(path)
    assert pixels.shape[1] > 300
    assert pixels.std() > 0.05, "it is not blank"


def test_the_same_run_as_a_command_and_in_python(opened: Open, tmp_path: Path) -> None:
    from pinchoff.cli import main

    page = opened()
    page.page.evaluate("explorer.set({offset: 0.07, vertex_count: 48, follow_daughters: false})")
    for physical in (False, True):
        if physical:
            page.page.click("#units")
        result = run_of(page)
        words = shlex.split(page.page.inner_text("#command"))
        assert words[0] == "pinchoff"
        out = tmp_path / f"run{physical}"
        assert main([*words[1:], "--out", str(out)]) == 0
        import json

        there = json.loads((out / "collision.json").read_text())["results"]
        assert there["symmetry"] == pytest.approx(result["symmetry"], abs=1e-12)
        names: dict[str, Any] = {}
        exec(page.page.inner_text("#python"), names)
        assert names["c"].symmetry == pytest.approx(result["symmetry"], abs=1e-12)
        assert names["c"].outcome == page.value("explorer.current().here.outcome")


def test_physical_quantities_give_pythons_groups(opened: Open) -> None:
    page = opened()
    page.page.click("#units")
    field = page.page.locator("#physical input").nth(4)  # viscosity
    field.fill("96")
    field.press("Tab")
    page.settled()
    quantities = page.value("explorer.state.quantities")
    units = page.value(
        "({diameter: 'um', obstacle_radius: 'um', thickness: 'um', speed: 'mm/s', "
        "viscosity: 'mPa s', surface_tension: 'mN/m', offset: 'um'})"
    )
    p = Parameters.from_physical(**{k: f"{v!r} {units[k]}" for k, v in quantities.items()})
    values = page.value("explorer.state.values")
    for name in ("size_ratio", "simulation_capillary_number", "offset"):
        assert values[name] == getattr(p, name)
    assert "µm" in page.page.inner_text("#numbers")


def test_the_tour_is_walked(opened: Open) -> None:
    page = opened()
    page.page.click("#tour-open")
    for stop in page.value("explorer.facts.tour"):
        page.settled()
        assert page.page.inner_text("#tour-title") == stop["title"]
        assert page.value("explorer.current().here.outcome") == stop["expect"]
        page.page.click("#tour-next")
    assert page.page.locator("#tour").is_hidden()


def test_examples_are_chosen(opened: Open) -> None:
    page = opened()
    for k, example in enumerate(page.value("explorer.facts.examples")):
        page.page.select_option("#example", str(k))
        page.settled()
        assert page.value("explorer.current().here.outcome") == example["expect"]


@pytest.mark.parametrize("width", [360, 1440, 2560])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_is_cut_off(opened: Open, width: int, scheme: str) -> None:
    page = opened(viewport={"width": width, "height": 800}, color_scheme=scheme)
    page.page.click("#units")
    page.settled()
    page.page.click("#tour-open")
    page.settled()
    page.page.evaluate("document.querySelectorAll('details').forEach(d => { d.open = true; })")
    assert page.value("document.documentElement.scrollWidth <= innerWidth")
    dark = page.value("getComputedStyle(document.body).backgroundColor")
    assert (sum(map(int, dark[4:-1].split(","))) < 200) == (scheme == "dark")
    page.page.click("#theme")
    other = page.value("getComputedStyle(document.body).backgroundColor")
    assert other != dark


def test_touch_moves_the_droplet(opened: Open) -> None:
    page = opened(has_touch=True, is_mobile=True, viewport={"width": 360, "height": 740})
    page.page.evaluate(
        """() => {
        const canvas = document.getElementById('scene'), s = explorer.scene;
        const box = canvas.getBoundingClientRect();
        const at = (x, y) => ({
            clientX: box.left + (x - s.view.left) * s.view.scale,
            clientY: box.top + box.height / 2 - y * s.view.scale,
            pointerId: 5, pointerType: 'touch', bubbles: true,
        });
        canvas.setPointerCapture = () => {};
        canvas.dispatchEvent(new PointerEvent('pointerdown', at(s.handle, 0.05)));
        canvas.dispatchEvent(new PointerEvent('pointermove', at(s.handle, 0.15)));
        canvas.dispatchEvent(new PointerEvent('pointerup', at(s.handle, 0.15)));
        }"""
    )
    assert page.value("explorer.state.values.offset") == pytest.approx(0.15, abs=0.01)
