"""The break-up law fitted to collisions: likelihood, intervals, noise, comparisons."""

from pinchoff.fits.fitted_law import LawFit
from pinchoff.fits.law_fit import fit_law

__all__ = ["LawFit", "fit_law"]
