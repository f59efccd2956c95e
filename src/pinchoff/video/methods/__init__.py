"""Segmentations, one a file, behind one interface."""
