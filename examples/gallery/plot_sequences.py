r"""
Faster or further off: what changes?
====================================

Two images of each collision, as in the paper's first figure: the fluid moves by 400 µm from one
to the other.
"""

import pinchoff as po


def collision(speed, offset):
    parameters = po.Parameters.from_physical(
        diameter="481 um",
        obstacle_radius="85 um",
        speed=speed,
        viscosity="48 mPa s",
        surface_tension="20 mN/m",
        thickness="85 um",
        offset=offset,
    )
    return po.simulate(parameters, outlines=0.02)


shown = [
    collision("1.8 mm/s", "0 um"),
    collision("1.4 mm/s", "50 um"),
    collision("0.8 mm/s", "50 um"),
]
panels = po.figures.collision_pairs(shown)
