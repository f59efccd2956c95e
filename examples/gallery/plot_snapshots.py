r"""
What happens in a collision?
============================

Six moments of one droplet. In the second, the dashed line divides it into the two areas of its
symmetry :math:`S`; in the fourth, the thinnest neck is marked.
"""

import pinchoff as po

collision = po.simulate(po.Parameters(simulation_capillary_number=25, offset=0.05), outlines=0.02)
panels = po.figures.snapshot_strip(collision.outlines)

# %%
# ``collision.plot()`` draws the same. With physical quantities, times and lengths have the units
# of the laboratory; ``times`` chooses the moments, in :math:`t_0 = D_0/v`.

parameters = po.Parameters.from_physical(
    diameter="481 um",
    obstacle_radius="85 um",
    speed="1.0 mm/s",
    viscosity="48 mPa s",
    surface_tension="20 mN/m",
    thickness="85 um",
    offset="60 um",
)
slower = po.simulate(parameters, outlines=0.02)
panels = po.figures.snapshot_strip(slower.outlines, times=[2.4, 3.0, 3.5])

# %%
# With the flow, its streamlines are drawn.

flow = po.flow.stokes(collision.parameters.obstacle_radius)
panels = po.figures.snapshot_strip(collision.outlines, times=[2.0, 2.6, 3.0], flow=flow)
