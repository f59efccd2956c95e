r"""
How are neck and symmetry measured?
===================================

A neck is a chord :math:`r_{ij}` between two vertices that are far apart along the outline. The
droplet breaks where it gets thinner than a threshold.
"""

import pinchoff as po

collision = po.simulate(po.Parameters(simulation_capillary_number=25, offset=0.05), outlines=0.01)
axes = po.figures.model_schematic(collision)

# %%
# The symmetry :math:`S` compares the two parts of the droplet at first contact. They lie on
# either side of the line through the obstacle's centre, along the droplet's velocity.

axes = po.figures.symmetry_construction(collision)
