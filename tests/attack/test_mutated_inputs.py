"""Configurations, options and tables, mutated at random, through the command line's entry point.

Each ends with exit code 0 or 2, in a line of our form, soon. `--attacks N` sets how many are tried:
as many configurations and options, and half as many tables. Another number draws others.
"""

from __future__ import annotations

import io
import random
import re
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff.cli import main

Attack = Callable[..., list[str]]

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
LINE = """\
vertex_count = 16
start_distance = 1.0
time_limit = 0.5
neck_thickness = 0.3
edge_stiffness = 2.0
model = "deformable-particle"
"""
EMULSION = """\
time = 4.0
interval = 0.2
seed = 1

[parameters]
simulation_capillary_number = 60
vertex_count = 16

[array]
kind = "square"
rows = 2
columns = 1
radius = 0.3
gap = 1.0
before = 1
behind = 1

[flow]
thickness = 0.5

[inlet]
area_fraction = 0.2
diameters = [1.0]

[coalescence]
drainage = 0.5
"""
CHAMBER = """\
thickness_um = 45

[imaging]
obstacle_radius_um = 60
pitch_um = 600
rows = 6
columns = 3
stagger = 0.5

[supports]
flank_um = 1000

[mask]
polarity = "dark-field"
chord_tolerance_um = 0.5
label = "R60 z45 dense"

[rules]
largest_aspect_ratio = 4
on_violation = "warn"

[operation]
oil_rate_uL_min = 30
droplet_diameter_um = 300
"""
CONFIGURATIONS = {
    "sweep": (SWEEP, ["sweep", "{config}", "--workers", "1"]),
    "run": (RUN, ["run", "{config}"]),
    "physical": (PHYSICAL, ["run", "{config}"]),
    "boundary": (LINE, ["boundary", "{config}", "--capillary", "40", "--scan", "4"]),
    "calibrate": (
        LINE,
        [
            *("calibrate", "0.083,-0.74,0.1,0.2", "{config}", "--free", "edge_stiffness"),
            *("--points", "3", "--width", "0.5", "--scan", "4", "--evaluations", "1"),
            *("--grid", "0"),
        ],
    ),
    "emulsion": (EMULSION, ["emulsion", "{config}", "--workers", "1"]),
    "chamber": (CHAMBER, ["chamber", "{config}"]),
}
"""By name: the configuration, and the command that takes it."""

OPTIONS = {
    "run": """\
--size-ratio = 5.0
--capillary = 20
--offset = 0.1
--set = vertex_count = 16
--set = time_limit = 0.05
--frames-every = 0.02
--format = png
""",
    "boundary": """\
--capillary = [20, 40]
--size-ratio = 5.0
--set = vertex_count = 16
--set = time_limit = 0.5
--width = 0.2
--scan = 4
""",
    "virtual": """\
--rows = 12
--seed = 3
--engine
--preset = default
--set = vertex_count = 16
--set = time_limit = 6
--set = ca_speed = contact
--symmetry-noise = 0.05
""",
    "chamber": """\
--obstacle-radius = 60 um
--thickness = 45 um
--set = imaging.rows = 6
--set = imaging.columns = 3
--set = mask.chord_tolerance_um = 0.5
--warn
""",
}
"""By command: its options, one a line; the first " = " stands for a space."""

COSTLY = ("calibrate", "emulsion", "chamber")
"""Of these a third as many are tried."""


def share(name: str, attacks: int) -> int:
    """Return how many of all attacks on configurations and options one kind of them gets."""
    weight = {each: 1 if each in COSTLY else 3 for each in (*CONFIGURATIONS, *OPTIONS)}
    total = sum(weight[each] for each in (*CONFIGURATIONS, *OPTIONS))
    return max(1, attacks * weight[name] // total)


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


def wrong_with(found: dict[str, str], wrong: list[str], content: str | bytes) -> None:
    """Keep the first of each kind of fault, with what caused it, for whoever mends it."""
    for each in wrong:
        kind = each.partition("\n")[0][:40] + each.strip().rpartition("\n")[2][:60]
        if kind not in found:
            folder = Path("build") / "attacks"
            folder.mkdir(parents=True, exist_ok=True)
            kept = folder / f"{abs(hash(kind)):x}"
            kept.write_bytes(content.encode() if isinstance(content, str) else content)
            found[kind] = f"{each}\n{content if isinstance(content, str) else kept}"


def filled(arguments: list[str], config: Path) -> list[str]:
    return [str(config) if text == "{config}" else text for text in arguments]


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_mutated_configurations(attack: Attack, attacks: int, tmp_path: Path, name: str) -> None:
    draw = random.Random(f"{name} {attacks}")
    base, arguments = CONFIGURATIONS[name]
    config = tmp_path / "given.toml"
    config.write_text(base)
    assert main([*filled(arguments, config), "--out", str(tmp_path / "base")]) == 0
    found: dict[str, str] = {}
    for k in range(share(name, attacks)):
        text = mutated_lines(draw, base)
        config.write_bytes(text.encode())
        out = tmp_path / str(k) / "out"
        wrong = attack([*filled(arguments, config), "--out", str(out)], out, draws=k % 10 == 0)
        wrong_with(found, wrong, text)
    assert not found, "\n\n".join(found.values())


def options_of(text: str) -> list[str]:
    """Return the options that stand in lines, as a shell would hand them over."""
    lines = text.replace("\0", "").splitlines()
    return [part for line in lines for part in line.split(" = ", 1)]


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("command", OPTIONS)
def test_mutated_options(attack: Attack, attacks: int, tmp_path: Path, command: str) -> None:
    draw = random.Random(f"{command} {attacks}")
    base = OPTIONS[command]
    assert main([command, *options_of(base), "--out", str(tmp_path / "base.csv")]) == 0
    found: dict[str, str] = {}
    for k in range(share(command, attacks)):
        text = mutated_lines(draw, base)
        folder = tmp_path / str(k)
        folder.mkdir()
        out = folder / "out.csv"
        given = [command, *options_of(text), "--out", str(out)]
        wrong_with(found, attack(given, out, draws=k % 10 == 0), text)
    assert not found, "\n\n".join(found.values())


def spreadsheet(draw: random.Random, text: str) -> bytes:
    """Return a text table as a spreadsheet, in three cases of four with a part that is damaged."""
    written, separator = io.BytesIO(), "\t" if "\t" in text else ","
    rows = [line.split(separator) for line in text.split("\n")]
    cells = [[_CONTROL.sub("", cell) for cell in row] for row in rows]
    pd.DataFrame(cells).map(_as_number).to_excel(written, header=False, index=False)
    with zipfile.ZipFile(written) as packed:
        parts = {name: packed.read(name) for name in packed.namelist()}
    name = draw.choice(sorted(parts))
    if (kind := draw.randrange(4)) == 1:
        del parts[name]
    elif kind == 2:
        parts[name] = mutated_bytes(draw, parts[name])
    damaged = io.BytesIO()
    with zipfile.ZipFile(damaged, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, part in parts.items():
            packed.writestr(name, part)
    return mutated_bytes(draw, damaged.getvalue()) if kind == 3 else damaged.getvalue()


_CONTROL = re.compile("[\0-\x1f]")


def _as_number(cell: str | None) -> str | float | None:
    try:
        number = float(cell or "")
    except ValueError:
        return cell
    return number if np.isfinite(number) else cell


def mutated_bytes(draw: random.Random, content: bytes) -> bytes:
    data = bytearray(content)
    for _ in range(draw.choice([1, 1, 4])):
        where = draw.randrange(len(data) or 1)
        if draw.random() < 0.7 and data:
            data[where] ^= 1 << draw.randrange(8)
        else:
            del data[where : where + draw.choice([1, 30, len(data)])]
    return bytes(data)


def parquet(draw: random.Random, frame: pd.DataFrame) -> bytes:
    written = io.BytesIO()
    frame.to_parquet(written, index=False)
    return mutated_bytes(draw, written.getvalue())


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("suffix", [".csv", ".tsv", ".xlsx", ".ods", ".parquet"])
def test_mutated_tables(
    attack: Attack, attacks: int, table: pd.DataFrame, tmp_path: Path, suffix: str
) -> None:
    draw = random.Random(f"{suffix} {attacks}")
    found: dict[str, str] = {}
    path = tmp_path / f"table{suffix}"
    share = {".csv": 0.4, ".tsv": 0.1, ".xlsx": 0.3, ".ods": 0.05, ".parquet": 0.15}[suffix]
    for k in range(max(1, round(attacks / 2 * share))):
        content = mutated_table(draw, table)
        if suffix in (".xlsx", ".ods"):
            content = spreadsheet(draw, content.decode("utf-8", "replace"))
        elif suffix == ".parquet":
            content = parquet(draw, table)
        path.write_bytes(content)
        out = tmp_path / str(k) / "law"
        options = ["--samples", "2", "--out", str(out)]
        options += draw.choice([[], [], ["--symmetry-noise", "0.088"], ["--free", "area"]])
        wrong_with(found, attack(["fit", str(path), *options], out, draws=k % 10 == 0), content)
    assert not found, "\n\n".join(found.values())


def test_the_mutations_differ(table):
    draw = random.Random(7)
    assert len({mutated_table(draw, table) for _ in range(50)}) > 45
    assert np.mean([mutated_lines(draw, SWEEP) != SWEEP for _ in range(50)]) > 0.9
