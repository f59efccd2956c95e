"""The model: parameters, flows, arrangements; runs of the engine and what comes of them."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules={"arrays", "flow"})
