"""The README's Python lines run as they stand and give what they say."""

import re
from pathlib import Path

import pinchoff as po

README = Path(__file__).parents[2] / "README.md"


def test_python_blocks(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.S)
    assert len(blocks) == 2
    for block in blocks:
        exec(compile(block, str(README), "exec"), names)
    collision = names["c"]
    assert collision.outcome == "broke"
    assert round(collision.symmetry, 2) == 0.78
    assert round(collision.daughter_area_ratio, 1) == 0.2
    assert len(po.Outlines.load(tmp_path / "outlines.gsd")) == len(collision.outlines)
    assert len(names["table"]) == 30
    assert round(names["p"].simulation_capillary_number, 1) == 24.5
