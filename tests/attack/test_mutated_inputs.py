"""Configurations and tables, mutated at random, through the command line's entry point.

Each ends with exit code 0 or 2, in a line of our form, soon. `--attacks N` sets how many are tried.
"""

from __future__ import annotations

import random
import re
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

import pinchoff as po
from pinchoff.cli import main
from pinchoff.figures import style

FORM = re.compile(r"error: .+ must be .+; got .*; .+", re.S)
LONGEST_S = 20.0
"""CPU time that an input may take."""

SWEEP = """\
design = "sobol"
samples = 4
seed = 3
start_distance = 1.0
time_limit = 0.05
vertex_count = 16
neck_separation_unit = "perimeter"
follow_daughters = true

[parameters]
edge_stiffness = 2.0

[vary]
offset = { min = 0.0, max = 0.3 }
line_tension = [60.0, 80.0]
"""
RUN = """\
offset = 0.05
vertex_count = 16
start_distance = 1.0
time_limit = 0.05
time_step = "auto"
neck_thickness = 0.167
"""
PHYSICAL = """\
vertex_count = 16
time_limit = 0.05

[physical]
diameter = "481 um"
obstacle_radius = "85 um"
speed = "1 mm/s"
viscosity = "48 mPa s"
surface_tension = "20 mN/m"
thickness = "85 um"
"""
VALUES = (
    *("nan", "inf", "-inf", "-1", "0", "1e-320", "1e308", "-0.0", "true", "false", "[]", "{}"),
    *('""', '"x"', '"1 um"', '"-3 mm/s"', '"µ"', "[1, 2]", '["a"]', "{ min = 1 }", "1979-05-27"),
    *("0.5", "2", "17", "9223372036854775808", '"1e999 um"', '"nan um"', "[[1]]", "'\\n'"),
)


def mutated_lines(draw: random.Random, text: str) -> str:
    """Replace, drop, double or break some lines of a configuration."""
    lines = text.splitlines()
    for _ in range(draw.choice([1, 1, 1, 2, 3])):
        k = draw.randrange(len(lines))
        kind = draw.randrange(8)
        values = list(re.finditer(r"(?<=[=\[,] )[^\s,\]}]+|(?<=\[)[^\s,\]]+", lines[k]))
        if kind <= 3 and values:
            place = draw.choice(values)
            lines[k] = lines[k][: place.start()] + draw.choice(VALUES) + lines[k][place.end() :]
        elif kind == 4:
            del lines[k]
        elif kind == 5:
            lines.insert(k, lines[draw.randrange(len(lines))])
        elif kind == 6:
            place = draw.randrange(len(lines[k]) + 1)
            lines[k] = lines[k][:place] + draw.choice("#='[]{}\"\\\0µ9x.\t") + lines[k][place:]
        else:
            lines[k] = lines[k].replace("_", draw.choice(["", "-", "__"]), 1)
        lines = lines or [""]
    return "\n".join(lines)


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    names = ["symmetry", "broke", "area_um2", "speed_mm_s", "obstacle_radius_um", "thickness_um"]
    names += ["viscosity_mPa_s", "surface_tension_mN_m"]
    return po.virtual_experiment(seed=2, n=60)[names]


CELLS = (
    *("", "nan", "inf", "-inf", "-1", "0", "1e400", "1e-320", "#DIV/0!", "#3", "1,5", "1.234,5"),
    *("12 %", "3 ± 1", "yes", "nein", '"', "'", "µ", "\0", "2024-01-01", "1e308", "TRUE", "  7  "),
)


def mutated_table(draw: random.Random, frame: pd.DataFrame) -> bytes:
    """Change cells, names, columns, separators and encodings of a table."""
    rows = [list(frame.columns), *frame.astype(str).to_numpy().tolist()]
    for _ in range(draw.choice([1, 1, 2, 4])):
        kind = draw.randrange(9)
        row, column = draw.randrange(len(rows)), draw.randrange(len(rows[0]))
        if kind <= 2:
            rows[row][column % len(rows[row])] = draw.choice(CELLS)
        elif kind == 3:
            for line in rows[1:]:
                line[column % len(line)] = draw.choice(CELLS[: draw.choice([1, 12, 24])])
        elif kind == 4:
            for line in rows:
                if len(line) > 1:
                    del line[column % len(line)]
        elif kind == 5:
            del rows[draw.randrange(1, len(rows) + 1) :]
        elif kind == 6:
            rows.insert(row, [draw.choice(CELLS)] * draw.choice([1, len(rows[0]), 30]))
        elif kind == 7:
            rows[0] = [draw.choice([str.upper, str.title, str])(name) for name in rows[0]]
        else:
            rows[row] = rows[row] + [draw.choice(CELLS)]
    separator = draw.choice([",", ",", ",", ";", "\t"])
    text = draw.choice(["\n", "\n", "\r\n", "\r"]).join(separator.join(line) for line in rows)
    encoding = draw.choice(["utf-8", "utf-8", "utf-8-sig", "utf-16", "cp1252"])
    encoded = text.encode(encoding, "replace")
    return encoded[: draw.randrange(1, len(encoded))] if draw.random() < 0.1 else encoded


def attack(arguments: list[str], content: bytes, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """Run a command; return what is wrong with how it ended."""
    start = time.process_time()
    try:
        code = main(["--debug", *arguments])
    except Exception as error:
        return [f"{type(error).__name__}: {error}"]
    took = time.process_time() - start
    said = capsys.readouterr().err
    errors = [line for line in said.splitlines() if line.startswith("error: ")]
    wrong = []
    if code not in (0, 2):
        wrong.append(f"exit code {code}: {said[-200:]}")
    if code == 2 and not (errors and FORM.match(said[said.index("error: ") :])):
        wrong.append(f"not in our form: {said[-200:]}")
    if took > LONGEST_S:
        wrong.append(f"{took:.0f} s")
    return wrong


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    ("command", "base"),
    [("sweep", SWEEP), ("run", RUN), ("run", PHYSICAL)],
    ids=["sweep", "run", "physical"],
)
def test_mutated_configurations(attacks, tmp_path, capsys, command, base):
    draw = random.Random(5)
    found: dict[str, str] = {}
    for k in range(attacks // 3):
        text = mutated_lines(draw, base)
        path = tmp_path / f"{k}.toml"
        path.write_bytes(text.encode())
        given = [str(path)] if command == "sweep" else ["--config", str(path)]
        wrong = attack([command, *given, "--out", str(tmp_path / f"out{k}")], b"", capsys)
        found |= {each.partition(": ")[0]: f"{each}\n{text}" for each in wrong}
    assert not found, "\n\n".join(found.values())


@pytest.mark.filterwarnings("ignore")
def test_mutated_tables(attacks, table, tmp_path, capsys, monkeypatch):
    """Of three tables in four the pictures are empty: drawing them takes longest."""
    draw = random.Random(6)
    save, empty = style.save, Figure(figsize=(1, 1)).subplots()
    found: dict[str, str] = {}
    path, out = tmp_path / "table.csv", tmp_path / "law"
    for k in range(attacks // 3):
        drawn = save if k % 4 == 0 else lambda path, _: save(path, empty)
        monkeypatch.setattr(style, "save", drawn)
        content = mutated_table(draw, table)
        path.write_bytes(content)
        options = ["--samples", "2", "--out", str(out), "--overwrite"]
        options += draw.choice([[], [], ["--symmetry-noise", "0.088"], ["--free", "area"]])
        wrong = attack(["fit", str(path), *options], content, capsys)
        for each in wrong:
            found[each.partition(": ")[0] + each[-40:]] = each
            _keep(content, len(found))
    assert not found, "\n\n".join(found.values())


def _keep(content: bytes, number: int) -> None:
    """Keep what was found, for whoever mends it."""
    folder = Path("build") / "attacks"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{number}.csv").write_bytes(content)


def test_the_mutations_differ(table):
    draw = random.Random(7)
    assert len({mutated_table(draw, table) for _ in range(50)}) > 45
    assert np.mean([mutated_lines(draw, SWEEP) != SWEEP for _ in range(50)]) > 0.9
