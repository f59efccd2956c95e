"""The line between droplets that break and droplets that do not, bracketed and fitted."""

from pinchoff.studies.boundary.search import Boundary, boundary

__all__ = ["Boundary", "boundary"]
