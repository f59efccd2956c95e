"""Figures: one module per figure, outlines or a table in, matplotlib Axes out."""
