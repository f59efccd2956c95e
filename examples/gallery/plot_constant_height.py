r"""
Why is the exponent near −3/4?
==============================

On the separating line the smaller parts of small and large droplets are nearly equally high.
Left, two droplets with that property; right, the exponent that one height gives.
"""

import pinchoff as po

panels = po.figures.constant_height()
