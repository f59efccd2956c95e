"""The break-up law fitted to collisions: likelihood, intervals, noise, comparisons."""

from pinchoff.fits.law_fit import LawFit, fit_law

__all__ = ["LawFit", "fit_law"]
