r"""
Where does break-up begin?
==========================

``po.boundary`` brackets the critical symmetry :math:`S_c` at each capillary number. Stars are its
runs; the line is fitted to the brackets.
"""

import pinchoff as po

boundary = po.boundary(
    po.Parameters(vertex_count=48), {"simulation_capillary_number": [16, 22, 30, 42, 58, 80]}
)
axes = po.figures.separating_line(boundary, boundary.fit())
