"""Tables from real desks: encodings, remarks, titles, units, sheets, words; no row is lost."""

from __future__ import annotations

import zipfile
from pathlib import Path

import openpyxl
import pandas as pd
import pytest

import pinchoff as po
from pinchoff.collisions import reading, spreadsheet
from pinchoff.collisions.reading import read_table

FAILING = Path(__file__).parents[3] / "shared" / "failing"
NAMES = ["symmetry", "broke", "area_um2", "speed_mm_s", "obstacle_radius_um", "thickness_um"]
ROWS = [
    [0.52, "no", 64046.5, 1.7, 85.0, 85.0],
    [0.18, "no", 42517.7, 1.2, 85.0, 85.0],
    [0.96, "yes", 234912.8, 1.8, 60.0, 85.0],
]
CONSTANTS = {"viscosity": "48 mPa s", "surface_tension": "20 mN/m"}


def csv_of(names=NAMES, rows=ROWS, separator=","):
    lines = [names, *rows]
    return "\n".join(separator.join(map(str, line)) for line in lines) + "\n"


@pytest.fixture
def imported(tmp_path):
    """Function (text or bytes, **how) -> ImportedCollisions of a CSV file."""

    def call(content, **how):
        path = tmp_path / "table.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return po.import_collisions(path, **{"constants": CONSTANTS, **how})

    return call


@pytest.fixture
def book(tmp_path):
    """Function ({sheet: rows}) -> path of a spreadsheet."""

    def write(sheets):
        workbook = openpyxl.Workbook()
        workbook.remove(workbook.active)
        for name, rows in sheets.items():
            sheet = workbook.create_sheet(name)
            for row in rows:
                sheet.append(row)
        workbook.save(tmp_path / "book.xlsx")
        return tmp_path / "book.xlsx"

    return write


def complete(imported):
    assert imported.count == len(imported.table) == 3
    assert imported.table["area_um2"].tolist() == pytest.approx([row[2] for row in ROWS])
    assert imported.table["broke"].tolist() == [False, False, True]


def test_a_sign_of_a_remark_cuts_no_column_and_no_row(imported):
    names = ["droplet #", "note", *NAMES]
    rows = [[k, "chip #3", *row] for k, row in enumerate(ROWS)]
    complete(imported(csv_of(names, rows)))


@pytest.mark.parametrize("error", ["#DIV/0!", "#N/A", "n.d.", "-", "#VALUE!"])
def test_rows_with_an_error_of_a_spreadsheet_are_counted(imported, error):
    found = imported(
        csv_of(rows=[*ROWS, [error, "no", *ROWS[0][2:]], [*ROWS[0][:3], error, 85, 85]])
    )
    assert (found.count, len(found.table)) == (5, 3)
    assert found.set_aside["row"].tolist() == [4, 5]
    assert found.reasons() == {
        "symmetry not measured": 1,
        "capillary_number needs speed, which is not given": 1,
    }


def test_remarks_and_a_header_that_is_one(imported):
    complete(imported("# chip 7, in spring\n\n# by hand\n" + csv_of()))
    numbers = [[row[0], int(row[1] == "yes"), *row[2:]] for row in ROWS]
    complete(imported("# made by a program\n# " + csv_of(rows=numbers)))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
def test_encodings_of_unicode_are_found(imported, encoding):
    names = [name.replace("area_um2", "area (µm²)") for name in NAMES]
    complete(imported(csv_of(names).encode(encoding)))


def test_other_encodings_are_guessed_aloud_or_asked_for(imported, refused):
    names = [name.replace("area_um2", "area (µm²)") for name in NAMES]
    content = csv_of(names).encode("latin-1")
    with pytest.warns(UserWarning, match=r"not UTF-8 \(line 1\): it is read as Windows-1252"):
        complete(imported(content))
    complete(imported(content, encoding="latin-1"))
    assert "write it like" in refused("encoding", imported, content, encoding="latin-99").advice
    refused("encoding", imported, content, encoding="utf-8")


def test_the_header_of_the_first_row_can_be_said(imported, refused):
    complete(imported(csv_of(), header_row=1))
    for row in (0, 99):
        assert "rows of the file" in refused("header_row", imported, csv_of(), header_row=row).rule


def test_an_index_without_a_name_and_small_tables(tmp_path):
    path = tmp_path / "table.csv"
    for names in (NAMES[:1], NAMES[:2], NAMES[:3], NAMES[:4], NAMES):
        frame = pd.DataFrame([row[: len(names)] for row in ROWS], columns=names)
        frame.to_csv(path)
        assert list(read_table(path).columns) in (["column.1", *names], names)
        assert len(read_table(path)) == 3
        frame.to_csv(path, index=False)
        assert list(read_table(path).columns) == names


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_title_above_the_header(imported, separator):
    for title in ("Collisions of chip 7, rerun\n\n", f"Chip 7{separator * 5}\n"):
        with pytest.warns(UserWarning, match="names the columns"):
            complete(imported(title + csv_of(separator=separator)))
        row = title.count("\n") + 1
        complete(imported(title + csv_of(separator=separator), header_row=row))


def test_a_row_of_units(imported, refused):
    names = ["Symmetry", "Broke", "Area", "Speed", "Obstacle radius", "thickness"]
    rows = [[*row[:2], row[2] / 1e6, row[3] * 1e3, *row[4:]] for row in ROWS]
    units = ["-", "", "mm^2", "[um/s]", "um", "µm"]
    with pytest.warns(UserWarning, match="row 2 is read as the units"):
        complete(imported(csv_of(names, [units, *rows])))
    wrong = ["-", "-", "mm^2", "mm/s", "um", "um"]
    with pytest.warns(UserWarning, match="row 2"):
        error = refused("unit of area", imported, csv_of(rows=[wrong, *ROWS]))
    assert "mm^2 for the column 'area_um2'" in error.got


def test_names_match_without_regard_to_case_or_spaces(imported, refused):
    names = ["SYMMETRY", "Broke", "Area_um2", "Speed (mm/s)", "obstacle radius_um", "Thickness_um"]
    complete(imported(csv_of(names)))
    twice = [*NAMES, "Symmetry ", "SYMMETRY"]
    rows = [[*row, 1, 2] for row in ROWS]
    complete(imported(csv_of(twice, rows)))  # the one of the very name counts
    twice[0] = "sYmmetry"
    refused("the column symmetry", imported, csv_of(twice, rows))


def test_fields_beyond_the_header(imported, refused, tmp_path):
    complete(imported("\n".join(line + ",," for line in csv_of().splitlines())))
    complete(imported(csv_of(rows=[[*row, ""] for row in ROWS])))
    error = refused(str(tmp_path / "table.csv"), imported, csv_of(rows=[*ROWS, [*ROWS[0], 7]]))
    assert error.got == "line 5 has 7 fields, the header 6"


@pytest.mark.parametrize(
    ("cell", "how"),
    [
        ('"64,046.5"', "without thousands separators"),
        ("64 046.5", "without thousands separators"),
        ('"64.046.012,5"', "without thousands separators"),
        ("52 %", "as a fraction of 1"),
        ("64046 ± 12", "without its error"),
        ("64046 +/- 12", "without its error"),
        ('"64046,5"', "with a point"),
        ("64046 um", "without its unit"),
    ],
)
def test_numbers_that_are_written_for_people_are_refused_by_cell(imported, refused, cell, how):
    rows = [*ROWS, [0.5, "no", cell, 1.0, 85.0, 85.0]]
    error = refused("area in row 4", imported, csv_of(rows=rows))
    assert how in error.advice


@pytest.mark.parametrize(
    ("unbroken", "broken"),
    [
        ("nein", "ja"),
        ("FALSCH", "WAHR"),
        ("no break", "breaks"),
        ("did not break", "broke"),
        ("non", "oui"),
        ("0.0", "1.0"),
    ],
)
def test_outcomes_in_words_of_many(imported, unbroken, broken):
    words = {"no": unbroken, "yes": broken}
    complete(imported(csv_of(rows=[[row[0], words[row[1]], *row[2:]] for row in ROWS])))


@pytest.mark.parametrize(("unbroken", "broken"), [("1", "2"), ("a", "b"), ("heil", "zerteilt")])
def test_outcomes_that_say_nothing_are_named_and_can_be_told(imported, refused, unbroken, broken):
    words = {"no": unbroken, "yes": broken}
    content = csv_of(rows=[[row[0], words[row[1]], *row[2:]] for row in ROWS])
    error = refused("broke", imported, content)
    assert error.got == f"'{unbroken}' (2), '{broken}' (1)"
    complete(imported(content, broke_is=[broken]))


def test_the_sheet_that_holds_a_table_is_read(book, refused):
    path = book({"Notes": [["notes"], ["chip 7"]], "Data": [NAMES, *ROWS], "More": [NAMES]})
    with pytest.warns(UserWarning, match="'Data' is read, not 'Notes', 'More'"):
        complete(po.import_collisions(path, constants=CONSTANTS))
    complete(po.import_collisions(path, constants=CONSTANTS, sheet="Data"))
    assert "did you mean 'Data'" in refused("sheet", read_table, path, sheet="Dta").advice


def test_merged_cells_and_units_above_the_data(book):
    top = ["droplet", None, None, None, "device", None]
    units = ["-", None, "um^2", "mm/s", "um", "um"]
    path = book({"Data": [top, NAMES, units, *ROWS]})
    with pytest.warns(UserWarning, match="row"):
        complete(po.import_collisions(path, constants=CONSTANTS))
    complete_row = read_table(path, header_row=2)
    assert list(complete_row.columns) == NAMES


def test_formulas_without_values_are_named(book, refused):
    path = book({"Data": [NAMES, *ROWS[:2], [*ROWS[2][:3], "=1.5*1.2", *ROWS[2][4:]]]})
    error = refused("cell D4 of book.xlsx", read_table, path)
    assert "=1.5*1.2" in error.got


def test_sizes_are_bounded_before_anything_is_parsed(book, refused, tmp_path, monkeypatch):
    path = tmp_path / "bomb.xlsx"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("xl/worksheets/sheet1.xml", b" " * 1_000_000)
    monkeypatch.setattr(spreadsheet, "MOST_BYTES", 500_000)
    assert "save it as CSV" in refused(str(path), read_table, path).advice
    monkeypatch.setattr(spreadsheet, "MOST_CELLS", 10)
    sheet = book({"Data": [NAMES, *ROWS]})
    refused(str(sheet), read_table, sheet)
    monkeypatch.setattr(reading, "MOST_BYTES", 100)
    text = tmp_path / "long.csv"
    text.write_text(csv_of())
    assert "save it as Parquet" in refused(str(text), read_table, text).advice


@pytest.mark.parametrize("kind", ["csv", "xlsx", "parquet"])
def test_damage_is_refused(tmp_path, kind):
    """Some bytes of a file are other ones: it is read or refused, and nothing else."""
    frame = pd.DataFrame(ROWS, columns=NAMES)
    path = tmp_path / f"table.{kind}"
    {"csv": frame.to_csv, "xlsx": frame.to_excel, "parquet": frame.to_parquet}[kind](
        path, index=False
    )
    whole = path.read_bytes()
    for k in range(0, len(whole), max(1, len(whole) // 60)):
        path.write_bytes(whole[:k] + bytes([whole[k] ^ 0x55]) + whole[k + 1 :])
        try:
            po.import_collisions(path, constants=CONSTANTS)
        except po.InputError:
            pass
        except UserWarning:  # warnings are errors in tests
            pass


def test_devices_and_options_of_other_files_are_refused(refused, tmp_path):
    refused("/dev/null", read_table, "/dev/null")
    path = tmp_path / "table.parquet"
    pd.DataFrame(ROWS, columns=NAMES).to_parquet(path)
    for name, value in (("sheet", "Data"), ("header_row", 2), ("encoding", "utf-8")):
        refused(name, read_table, path, **{name: value})


@pytest.mark.skipif(not FAILING.is_dir(), reason="the samples are not beside this checkout")
@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("name", ["hash_header", "note_hash", "na_mid", "excel_errors", "latin1"])
def test_samples_are_read_whole(name):
    path = FAILING / f"{name}.csv"
    found = po.import_collisions(path)
    lines = [line for line in path.read_bytes().split(b"\n") if line.strip()]
    assert found.count == len(found.table) + len(found.set_aside) == len(lines) - 1
