r"""
What do the model's constants change?
=====================================

A calibration to the paper's simulated line: the critical symmetries before and after a short
search over one constant.
"""

import pinchoff as po

found = po.calibrate(
    "paper-simulation",
    {"edge_stiffness": (1.0, 6.0)},
    base=po.Parameters(vertex_count=32),
    points=3,
    evaluations=4,
    scan=8,
    grid=0,
)
axes = po.figures.calibrated_line(found)
