"""The colours of everything that is drawn: figures, films, pages.

Categories take the palette of Okabe and Ito, which readers with any colour vision can tell apart
[M. Okabe and K. Ito, Color Universal Design, 2008]. Ordered quantities, such as D0/R, take a map
that grows evenly in lightness.
"""

from __future__ import annotations

BLACK = "#000000"
BLUE = "#0072b2"
SKY = "#56b4e9"
GREEN = "#009e73"
ORANGE = "#e69f00"
VERMILION = "#d55e00"
PINK = "#cc79a7"
YELLOW = "#f0c419"
GREY = "#999999"

CATEGORIES = (BLUE, VERMILION, GREEN, PINK, ORANGE, SKY, BLACK)
"""Colours of things that have no order, in the order in which they are taken."""

ORDERED_MAP = "viridis"
"""Name of matplotlib's map for quantities that have an order."""

BROKE = GREEN
UNBROKEN = "#7b5ea7"
REJECTED = "#bbbbbb"
"""What came of a collision."""

SIMULATED = "#d00000"
"""An outline of a simulation over a frame of a film."""

SIMULATION_LINE = BLUE
EXPERIMENT_LINE = VERMILION
FITTED_LINE = BLACK
"""The paper's two separating lines, and the one fitted here."""

DROPLET = "#f2a6bd"
DROPLET_RIM = "#40202c"
FLUID = "#eeeeec"
OBSTACLE = "#4d4d4d"
INK = "#1a1a1a"
NECK = VERMILION
CENTRELINE = BLUE
"""The chamber as a microscope shows it; droplets are pink with a dark rim."""
