r"""
What does the device look like?
===============================

The paper's microfluidic chamber, as a parametric design.
"""

from pinchoff.chamber import Chamber, check_flow
from pinchoff.figures.chamber_design import chamber_design
from pinchoff.figures.chamber_flow import chamber_flow

chamber = Chamber()
axes = chamber_design(chamber)

# %%
# The flow of oil through it, on a coarse mesh: the speed in the device, streamlines round one
# obstacle, and two profiles.

panels = chamber_flow(check_flow(Chamber(operation={"elements_across_gap": 4})))
