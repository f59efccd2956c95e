r"""
How does it move?
=================

A film of a run, as a player. ``collision.animate("collision.gif")`` writes it into a file: GIF,
MP4 or HTML.
"""

# sphinx_gallery_thumbnail_path = "images/collision.png"

import pinchoff as po

collision = po.simulate(po.Parameters(simulation_capillary_number=25, offset=0.05), outlines=0.1)
collision.animate(fps=10)
