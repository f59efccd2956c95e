r"""
How large are the daughters?
============================

The ratio of the daughters' areas against the symmetry. A daughter made of the whole smaller part
would lie on the dotted curve.
"""

import pinchoff as po

table = po.simulate_many(
    {
        "simulation_capillary_number": [25, 35, 50, 70],
        "offset": [0.0, 0.02, 0.04, 0.06, 0.08, 0.1, 0.12, 0.14],
        "vertex_count": [48],
    }
)
broke = table[table["broke"]]
axes = po.figures.daughter_areas(broke, curves=broke)
