"""Where the droplets of an emulsion come from, through break-ups and merges."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd


def lineage(events: pd.DataFrame) -> pd.DataFrame:
    """Return where every droplet comes from, and what became of it.

    Returns
    -------
    DataFrame
        Indexed by droplet_id: parent (-1: none; of a merged droplet the larger of the two),
        other_parent (-1: none; the smaller of two that merged) and share, the part of the area
        that came from the parent; born and ended, t0 (NaN: at the start, or never), fate
        ("breakup", "merge", "left", "retired" or ""), and area at birth, D0² (NaN if it was there
        at the start).

    Examples
    --------
    >>> import pandas as pd
    >>> events = pd.DataFrame({"kind": ["breakup"], "time": [2.0], "droplet_id": [0],
    ...     "daughter_1": [1], "daughter_2": [2], "area_1": [0.3], "area_2": [0.4], "area": [0.7]})
    >>> lineage(events)["parent"].to_dict()
    {0: -1, 1: 0, 2: 0}
    """
    import pandas as pd

    rows: dict[int, dict[str, float | int | str]] = {}

    def droplet(number: int) -> dict[str, float | int | str]:
        new: dict[str, float | int | str]
        new = {"parent": -1, "other_parent": -1, "share": 1.0}
        new |= {"born": math.nan, "ended": math.nan, "fate": "", "area": math.nan}
        return rows.setdefault(number, new)

    for event in events.to_dict("records"):
        kind, number = str(event["kind"]), int(event["droplet_id"])
        if kind == "entered":
            droplet(number).update(born=event["time"], area=event["area"])
        elif kind in ("left", "retired", "breakup"):
            droplet(number).update(ended=event["time"], fate=kind)
        if kind == "breakup":
            for k in (1, 2):
                daughter = droplet(int(event[f"daughter_{k}"]))
                daughter.update(parent=number, born=event["time"], area=event[f"area_{k}"])
        if kind == "merge":
            parts = [(event["area_1"], number), (event["area_2"], int(event["partner"]))]
            for _, part in parts:
                droplet(part).update(ended=event["time"], fate=kind)
            (larger, parent), (smaller, other) = sorted(parts, key=lambda one: -one[0])
            droplet(int(event["into"])).update(
                parent=parent,
                other_parent=other,
                share=larger / (larger + smaller),
                born=event["time"],
                area=larger + smaller,
            )
    table = pd.DataFrame.from_dict(rows, orient="index").sort_index()
    table.index.name = "droplet_id"
    return table


def ancestors(family: pd.DataFrame, droplet_id: int) -> Iterator[int]:
    """Yield a droplet's mother, her mother, and so on; `family` is that of `lineage`.

    Of two that merged the larger one is the mother.
    """
    parent = int(family["parent"].get(droplet_id, -1))
    while parent >= 0:
        yield parent
        parent = int(family["parent"].get(parent, -1))


def origins(family: pd.DataFrame, droplet_id: int) -> dict[int, float]:
    """Return where a droplet comes from: of the first droplets, the shares in its area.

    A break-up gives both daughters the mother's mixture; a merge mixes by areas.

    Parameters
    ----------
    family : DataFrame
        Of `lineage`.
    droplet_id : int

    Returns
    -------
    dict of int to float
        Shares that add up to 1, by the numbers of droplets that have no parent.

    Examples
    --------
    >>> import pandas as pd
    >>> events = pd.DataFrame({"kind": ["merge"], "time": [2.0], "droplet_id": [0], "partner": [1],
    ...     "into": [2], "area_1": [0.25], "area_2": [0.75], "area": [1.0]})
    >>> origins(lineage(events), 2)
    {0: 0.25, 1: 0.75}
    """
    found: dict[int, float] = {}
    parents = family["parent"].to_dict()
    others = family["other_parent"].to_dict()
    shares = family["share"].to_dict()
    # Droplets get their numbers in the order of their births: the youngest first.
    waiting = {droplet_id: 1.0}
    while waiting:
        youngest = max(waiting)
        part = waiting.pop(youngest)
        parent, other = int(parents.get(youngest, -1)), int(others.get(youngest, -1))
        if parent < 0:
            found[youngest] = found.get(youngest, 0.0) + part
            continue
        share = float(shares[youngest])
        waiting[parent] = waiting.get(parent, 0.0) + part * share
        if other >= 0:
            waiting[other] = waiting.get(other, 0.0) + part * (1.0 - share)
    return dict(sorted(found.items()))
