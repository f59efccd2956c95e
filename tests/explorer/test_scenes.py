"""What the page says of the model, and what its examples and its tour claim."""

from __future__ import annotations

import json
import re

import pytest

import pinchoff as po
from pinchoff import Parameters
from pinchoff.explorer.facts import facts
from pinchoff.model.parameters import DEFAULTS, PARAMETERS

FACTS = facts()
SCENES = [*FACTS["examples"], *FACTS["tour"]]


def scene(title: str) -> po.Collision:
    values = next(each["values"] for each in SCENES if each["title"] == title)
    return po.simulate(Parameters(**values))


@pytest.mark.parametrize("each", SCENES, ids=lambda each: each["title"])
def test_scenes_end_as_they_say(each: dict) -> None:
    assert po.simulate(Parameters(**each["values"])).outcome == each["expect"]
    assert each["at"] in ("entry", "contact", "break-up", "end")


def test_the_tour_has_twenty_stops_of_three_sentences() -> None:
    assert len(FACTS["tour"]) == 20
    for stop in FACTS["tour"]:
        assert len(re.findall(r"[.?!](?:\s|$)", stop["text"])) == 3, stop["title"]


def test_the_examples_lie_where_their_names_say() -> None:
    numbers = {each["title"]: scene(each["title"]).to_row()["breakup_number"] for each in SCENES}
    assert 0.9 < numbers["just below the line"] < 1.0 < numbers["just above the line"] < 1.2
    assert scene("head-on").symmetry == pytest.approx(1.0)


def test_what_the_tour_says_is_so() -> None:
    first, head_on = scene("A droplet meets a pillar"), scene("Head-on")
    assert head_on.daughter_area_ratio == pytest.approx(1.0, abs=1e-6)
    assert scene("A little to the side").daughter_area_ratio == pytest.approx(0.2, abs=0.02)
    mirror = scene("Mirror images")
    assert mirror.symmetry == pytest.approx(first.symmetry, abs=1e-9)
    assert mirror.breakup_time == pytest.approx(first.breakup_time, abs=1e-6)
    small_fast = scene("A small droplet in a fast flow")
    assert small_fast.to_row()["breakup_number"] < 1
    assert small_fast.maximum_shape_parameter > 1.3 * first.maximum_shape_parameter
    large = scene("A large droplet").to_row()["breakup_number"]
    assert large > 2 * first.to_row()["breakup_number"]
    assert scene("Twice broken").droplet_count == 3
    thick = scene("Where the model cuts")
    assert thick.breakup_time < first.breakup_time
    assert thick.daughter_area_ratio > first.daughter_area_ratio
    assert thick.symmetry == first.symmetry
    assert scene("Without a cut").minimum_neck == pytest.approx(0.12, abs=0.005)
    fast = scene("Fast flow")
    assert fast.breakup_time - fast.contact_time < 0.55 * (first.breakup_time - first.contact_time)
    assert fast.daughter_area_ratio > 0.5
    freed = po.simulate(Parameters(size_ratio=2.0, offset=0.02))
    assert freed.outcome == "slipped", "the caught droplet slips when moved a fiftieth"


def test_every_parameter_is_told_with_its_limits() -> None:
    json.dumps(FACTS, allow_nan=False)
    told = {each["name"]: each for each in FACTS["parameters"]}
    # What only says how a run is read, and not how it goes, is not on the page.
    assert told.keys() == {name for name, entry in PARAMETERS.items() if entry.in_core}
    for name in told.keys() & DEFAULTS.keys():
        assert told[name]["default"] == DEFAULTS[name]
    for name, each in told.items():
        for end in ("low", "high"):
            if each[end] is None:
                continue
            beyond = each[end] + (1 if end == "high" else -1) * max(1.0, abs(each[end]))
            with pytest.raises(po.InputError):
                Parameters(**{name: int(beyond) if each["whole"] else beyond})
    numbers = [each for each in told.values() if each["low"] is not None]
    assert len(numbers) >= 12
