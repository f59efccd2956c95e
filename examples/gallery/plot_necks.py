r"""
What does a camera see of a neck?
=================================

Left, the thinnest necks of synthetic collisions. Right, the neck in a film's last frame before
the break-up: the slower the camera, the thicker the last neck that it sees.
"""

import pinchoff as po
from pinchoff.studies.necks import thinning_history

parameters = po.Parameters.from_physical(
    diameter="481 um",
    obstacle_radius="85 um",
    speed="1.0 mm/s",
    viscosity="48 mPa s",
    surface_tension="20 mN/m",
    thickness="85 um",
    offset="0 um",
)
collision = po.simulate(parameters, outlines=0.002)
table = po.simulate_many(parameters.replace(offset=0.005 * k, vertex_count=48) for k in range(60))
history = thinning_history(collision).pinched_off(speed_mm_s=4.2)
panels = po.figures.neck_histograms(table[table["accepted"]], history)
