"""What everything else stands on: errors, checked models, units, files, progress."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules={"errors"})
