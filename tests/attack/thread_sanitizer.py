"""Both pools of threads under the thread sanitizer.

    cmake --preset tsan && cmake --build --preset tsan
    LD_PRELOAD=$(g++ -print-file-name=libtsan.so) python tests/attack/thread_sanitizer.py build/tsan

The package's Python is that of the checkout, its core the one that was just built. Every race is
reported on stderr; the exit code is 66 if there was one.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
import warnings
from pathlib import Path


def overlaid(build: Path) -> str:
    """Return a folder with the checkout's Python and the sanitized core."""
    folder = tempfile.mkdtemp(prefix="pinchoff-tsan-")
    source = Path(__file__).parents[2] / "src" / "pinchoff"
    shutil.copytree(source, Path(folder, "pinchoff"), ignore=shutil.ignore_patterns("*.so"))
    for core in build.glob("_core*.so"):
        shutil.copy(core, Path(folder, "pinchoff"))
    return folder


def main(build: str) -> None:
    folder = overlaid(Path(build))
    # An editable installation would answer first.
    sys.meta_path[:] = [finder for finder in sys.meta_path if "ScikitBuild" not in repr(finder)]
    sys.path.insert(0, folder)
    import numpy as np

    import pinchoff as po

    assert Path(po._core.__file__).is_relative_to(folder), po._core.__file__
    rows = [
        po.Parameters(simulation_capillary_number=ca, offset=offset, follow_daughters=True)
        for ca in (15, 25, 40, 80)
        for offset in np.linspace(0.0, 0.4, 10)
    ]
    table = po.simulate_many(rows, threads=4)
    print(f"simulate_many: {len(table)} collisions on 4 threads, {table['broke'].sum()} broke")
    starts = [[x, y, 0.9] for x in np.arange(6) * 1.3 for y in np.arange(6) * 1.3]
    for model in ("front-tracking", "deformable-particle"):
        for coalescence in (None, po.Coalescence(0.01, stochastic=True)):
            run = po.simulate_emulsion(
                po.Parameters(simulation_capillary_number=20, model=model, vertex_count=32),
                time=3,
                droplets=starts,
                obstacles=[[9.0, y, 0.4] for y in np.arange(5) * 1.6],
                flow=po.flow.uniform(),
                coalescence=coalescence,
                threads=4,
            )
            print(f"simulate_emulsion, {model}, {coalescence}: {run.balance}")
    shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main(sys.argv[1])
