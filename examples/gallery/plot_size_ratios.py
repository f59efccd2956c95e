r"""
Does one line serve all sizes?
==============================

Critical symmetries of droplets of several sizes. Left, against :math:`\mathrm{Ca}\,\tilde
A\,\tilde z`; right, with :math:`\tilde A` to the power that brings them nearest to one line. The
colours are in the order of :math:`D_0/R`.
"""

import pinchoff as po

boundary = po.boundary(
    po.Parameters(),
    {"size_ratio": [4, 5, 6, 8], "simulation_capillary_number": [25, 40, 64]},
    width=0.01,
    scan=12,
)
panels = po.figures.area_collapse(boundary)
