r"""
Which droplets break?
=====================

Every collision of a sweep by its symmetry :math:`S` and by :math:`\mathrm{Ca}\,\tilde A\,\tilde
z`: the capillary number, the droplet's area over :math:`R^2` and the chamber's thickness over
:math:`R`, where :math:`R` is the obstacle's radius. Any table of collisions will do, simulated or
measured.
"""

import numpy as np

import pinchoff as po

table = po.simulate_many(
    {
        "simulation_capillary_number": np.geomspace(10, 90, 12),
        "offset": np.linspace(0, 0.3, 16),
        "vertex_count": [48],
        "follow_daughters": [False],
    }
)
axes = po.figures.phase_diagram(table)
