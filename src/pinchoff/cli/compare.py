"""``pinchoff compare``: a measured collision beside its simulation."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pinchoff.cli.folders import Results
from pinchoff.cli.options import argument, grouped, named_as_options, option
from pinchoff.cli.output import bar
from pinchoff.support.records import write_json

_PICTURE = "comparison.png"
_NUMBERS = "comparison.json"


@grouped(out="comparison")
def compare(
    clip: Annotated[Path, argument("CLIP", "Folder of a measured clip, DIR/clips/NAME")],
    collision: Annotated[
        int, option("INTEGER", "Its collision_id in the clip's collisions.parquet")
    ],
    results: Results,
) -> None:
    """Simulate a measured collision and lay it over the film.

    The simulation has the measured D0/R and Ca. The flow's speed and the
    droplet's start are chosen so that at contact the droplet has the measured
    speed and the measured S (or b, where S is 0). DIR gets

    - comparison.png: six frames with the simulated outline in red at the same
      times, the path of the centre of mass and the shape parameter of both
    - comparison.json: what was matched, and the root mean square differences

    [bold]Example[/bold]

    pinchoff compare measured/clips/clip --collision 3 --out comparison
    """
    from pinchoff.figures import style
    from pinchoff.figures.filmed_comparison import compared
    from pinchoff.video.comparison import ROUNDS, compare_collision

    with results.held_for((_PICTURE, _NUMBERS)) as folder:
        with (
            named_as_options(collision_id="--collision"),
            bar("simulate", ROUNDS, "rounds") as show,
        ):
            found = compare_collision(clip, collision, progress=show)
        style.save(folder / _PICTURE, compared(found)[0])
        numbers = found.to_dict()
        write_json(folder / _NUMBERS, numbers)
    files = (folder / _PICTURE, folder / _NUMBERS)
    results.announce(numbers, lambda: _tell(numbers), files)


def _tell(numbers: Mapping[str, Any]) -> None:
    print(f"filmed {numbers['measured_outcome']}, simulated {numbers['simulated_outcome']}")
    print(f"centre of mass: root mean square distance {numbers['position_rms_um']:.1f} µm")
    print(f"shape parameter: root mean square difference {numbers['shape_rms']:.3f}")
