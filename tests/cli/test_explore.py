"""``pinchoff explore``, as users call it."""

from __future__ import annotations

import webbrowser
from pathlib import Path

import pytest

from pinchoff.cli import main
from pinchoff.explorer import page

ROWS = "symmetry,broke,capillary_number,normalized_area,normalized_thickness\n0.5,no,0.002,25,1\n"


@pytest.fixture
def built() -> None:
    if not page.is_built():
        pytest.skip("the explorer's page is not built; `make explorer` builds it")


@pytest.mark.usefixtures("built")
def test_alone_it_opens_the_live_page(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda url: opened.append(url) or True)
    assert main(["explore"]) == 0
    [url] = opened
    assert url.startswith("file:")
    assert "pinchoff explorer" in Path(url.removeprefix("file://")).read_text(encoding="utf-8")


@pytest.mark.usefixtures("built")
def test_without_a_browser_it_says_where_the_page_is(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(webbrowser, "open", lambda url: False)
    assert main(["explore"]) == 0
    said = capsys.readouterr()
    assert said.out.startswith("wrote ")
    assert "none could be started here" in said.err


@pytest.mark.usefixtures("built")
def test_a_table_goes_into_the_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "mine.csv").write_text(ROWS + "9,no,0.002,25,1\n")
    out = tmp_path / "mine.html"
    assert main(["explore", str(tmp_path / "mine.csv"), "--out", str(out)]) == 0
    assert '"title":"mine.csv"' in out.read_text(encoding="utf-8")
    assert "1 of 2 rows are set aside" in capsys.readouterr().err
    assert main(["explore", str(tmp_path / "mine.csv"), "--out", str(out)]) == 2
    assert "add --overwrite" in capsys.readouterr().err
    assert main(["explore", str(tmp_path / "mine.csv"), "--out", str(out), "--overwrite"]) == 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nothing"], "must be a readable table"),
        (["--out", "page.txt"], "--out must be a name ending in .html"),
        (["--out", "no/such/page.html"], "--out must be a file in an existing folder"),
        (["--map", "symmetry=S"], "DIR_OR_TABLE must be given beside options about it"),
        (["mine.csv", "--map", "symmetry"], "--map must be NAME=VALUE"),
        (["mine.csv", "--map", "symmetry=S"], "--map symmetry must be"),
        (["empty"], "must be a collisions table"),
        (["fitted"], "got a fit without collisions.parquet"),
    ],
)
def test_what_is_wrong_is_named(
    arguments: list[str],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "mine.csv").write_text(ROWS)
    (tmp_path / "empty").mkdir()
    (tmp_path / "fitted").mkdir()
    (tmp_path / "fitted" / "law.json").write_text("{}")
    monkeypatch.chdir(tmp_path)
    assert main(["explore", *arguments]) == 2
    assert said in capsys.readouterr().err


def test_a_package_without_the_page_says_how_to_make_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(page, "BUILT", "missing.html")
    assert main(["explore", "--out", str(tmp_path / "page.html")]) == 2
    assert "make explorer" in capsys.readouterr().err
    assert not (tmp_path / "page.html").exists()


@pytest.mark.usefixtures("built")
def test_a_fit_links_to_its_explorer(tmp_path: Path) -> None:
    table, law = str(tmp_path / "v.parquet"), tmp_path / "law"
    assert main(["virtual", "--rows", "300", "--out", table]) == 0
    assert main(["fit", table, "--samples", "3", "--out", str(law)]) == 0
    assert 'href="explore.html"' in (law / "report.html").read_text(encoding="utf-8")
    text = (law / "explore.html").read_text(encoding="utf-8")
    assert '"label":"fit of law"' in text
    assert main(["explore", str(law), "--out", str(tmp_path / "again.html")]) == 0
