"""The engine beside a straightforward program that shares no line with it, and with itself."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

from pinchoff import _core

COLLISIONS = [(20.0, 0.05, 5.66), (40.0, 0.02, 5.66), (60.0, 0.1, 4.0), (30.0, 0.03, 7.5)]


@pytest.mark.parametrize(("capillary", "offset", "size_ratio"), COLLISIONS)
def test_collision_equals_that_of_an_independent_program(
    model, run, reference, capillary, offset, size_ratio
):
    """Plain velocity Verlet, one struct a vertex: S to 1e-3, contact to two steps, same outcome.

    Both run with the paper's step of 1e-4 t0 and the default preset's stiffnesses.
    """
    step = 1e-4
    arguments = (64, 0, capillary, offset, size_ratio, step)
    expected = reference("collision", *arguments)
    (got,) = run(
        model(
            simulation_capillary_number=capillary,
            offset=offset,
            size_ratio=size_ratio,
            time_step=step,
            follow_daughters=False,
        )
    )
    assert ("slipped", "broke")[int(got["outcome"])] == expected["outcome"]
    assert got["symmetry"] == pytest.approx(expected["symmetry"], abs=1e-3)
    assert got["impact_parameter"] == pytest.approx(expected["impact_parameter"], abs=1e-3)
    assert got["contact_time"] == pytest.approx(expected["contact_time"], abs=2 * step)
    assert got["contact_speed"] == pytest.approx(expected["contact_speed"], rel=0.01)
    # The reference looks every 100 steps, 0.01 t0.
    assert got["end_time"] == pytest.approx(expected["end_time"], abs=0.011)


SCRIPT = """
import sys
import numpy as np
from pinchoff import _core
results = _core.run_many(np.load(sys.argv[1]), None, 1, None)
np.savez(sys.argv[2], name=_core.instruction_set(), results=results)
"""


def test_instruction_sets_agree(model, tmp_path):
    """Each set of loops that this machine has gives the same S to 1e-6 and the same outcomes."""
    rng = np.random.default_rng(1)
    rows = [
        model(
            offset=rng.uniform(-0.15, 0.15),
            simulation_capillary_number=rng.uniform(10, 90),
            size_ratio=rng.uniform(3, 7),
            vertex_count=int(rng.choice([47, 64])),
            follow_daughters=False,
        )
        for _ in range(20)
    ]
    np.save(tmp_path / "rows.npy", np.array(rows))
    found = {}
    for name in ("generic", "x86_64_v3", "x86_64_v4"):
        subprocess.run(
            [sys.executable, "-c", SCRIPT, tmp_path / "rows.npy", tmp_path / "out.npz"],
            check=True,
            env={**os.environ, "PINCHOFF_INSTRUCTION_SET": name},
        )
        with np.load(tmp_path / "out.npz") as out:
            found[str(out["name"])] = out["results"]
    assert "generic" in found
    if len(found) == 1:
        pytest.skip("this machine has the plain loops only")
    assert np.isfinite(found["generic"][:, _core.RESULT_FIELDS.index("symmetry")]).sum() > 10
    for name, results in found.items():
        for field in ("outcome", "symmetry", "contact_time", "small_daughter_area"):
            column = _core.RESULT_FIELDS.index(field)
            np.testing.assert_allclose(
                results[:, column],
                found["generic"][:, column],
                rtol=1e-6,
                atol=1e-6,
                err_msg=f"{name}: {field}",
            )


@pytest.mark.parametrize("count", [16, 37, 64])
def test_padding_of_the_arrays_does_not_show(model, run, count):
    """Vertex counts that do not fill the last register give the same physics as those that do."""
    around = [run(model(vertex_count=n, offset=0.1))[0]["symmetry"] for n in (count, count + 1)]
    assert around[0] == pytest.approx(around[1], abs=0.05)
