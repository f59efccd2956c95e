r"""
Do viscosity and tension act through their ratio?
=================================================

They do, as in the paper's appendix C: the critical symmetries of three line tensions
:math:`\tilde\gamma` fall on one line when they are drawn against the ratio
:math:`\tilde\mu/\tilde\gamma`.
"""

import pinchoff as po

boundary = po.boundary(
    po.Parameters(),
    {"line_tension": [60, 120, 240], "simulation_capillary_number": [25, 40, 64]},
    width=0.01,
    scan=12,
)
panels = po.figures.appendix_c(boundary)
