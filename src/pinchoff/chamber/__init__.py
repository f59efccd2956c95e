"""The microfluidic device: one geometry, from which masks, checks, flow and positions follow.

Names load on first use, those of `__init__.pyi`: the geometry needs shapely and gdstk, the flow
scikit-fem, all of them in ``pip install 'pinchoff[chamber]'``.
"""

from typing import Any

import lazy_loader

from pinchoff.chamber.extra import chamber_extra

_attribute, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    """Load a public name on first use."""
    with chamber_extra():
        return _attribute(name)
