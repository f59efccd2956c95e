"""From microscope films to collisions, and from known outlines to films."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules={"microscope"})
