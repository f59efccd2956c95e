"""The numbers of the paper, each once: its experiments, its model and what it found.

Meer, Sista, Shattuck, O'Hern and Weeks, Soft Matter 2026, doi 10.1039/D5SM01266J.
"""

from __future__ import annotations

# The standard experiment [section 2]
OBSTACLE_RADIUS_UM = 85.0
THICKNESS_UM = 85.0
OIL_DENSITY_KG_M3 = 960.0
VISCOSITY_MPA_S = 48.0
"""Of the 50 cSt oil."""
THICK_VISCOSITY_MPA_S = 96.0
"""Of the 100 cSt oil."""
SURFACE_TENSION_MN_M = 20.0
MEDIAN_DIAMETER_UM = 481.0
"""Of the droplets that broke."""

# What was varied [section 2]
OBSTACLE_RADII_UM = (60.0, 85.0, 120.0)
THICKNESSES_UM = (45.0, 85.0)
SPEEDS_MM_S = (0.5, 2.0)
"""From the slowest to the fastest droplet."""
DIAMETERS_UM = (100.0, 600.0)
"""From the smallest to the largest droplet."""
COLLISION_COUNT = 5056

# What was measured, and how [sections 2 and 4]
PIXEL_SIZE_UM = 5.28
FRAME_RATE = 60.0
"""Frames per second."""
OIL_RATES_UL_MIN = (20.0, 40.0, 60.0)
SYMMETRY_NOISE = 0.088
"""Uncertainty of S."""

# The model [section 3]
CA_PER_CA_SIM = 9.8e-5
"""Capillary number of the experiment per that of the simulation [eq. conv]."""
NECK_THICKNESS = 0.167
"""A thinner neck breaks, D0."""
NECK_SEPARATION = 0.28
"""Shortest arc between the two sides of a neck. The paper writes D0; as a fraction of the current
perimeter its separating line comes out."""

# The break-up law [section 4.2]
EXPERIMENT_ALPHA, EXPERIMENT_BETA = 0.083, -0.74
"""Separating line of the experiments."""
SIMULATION_ALPHA, SIMULATION_BETA = 0.089, -0.72
"""Separating line of the simulations."""
WIDTH = 0.098
"""w of the fit to the experiments."""
EXPERIMENT_FIT = {
    "alpha": (EXPERIMENT_ALPHA, 0.006),
    "beta": (EXPERIMENT_BETA, 0.03),
    "w": (WIDTH, 0.006),
}
"""The fit to the experiments: value and uncertainty of each number."""
