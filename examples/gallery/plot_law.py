r"""
How sharp is the transition?
============================

The share of collisions that break against the breakup number :math:`\mathrm{Bk}`, with binomial
intervals and the fitted law. The collisions are synthetic here: drawn from the paper's law under
the conditions of its experiments.
"""

import pinchoff as po

collisions = po.import_collisions(po.virtual_experiment(1, 3000))
fit = po.fit_law(collisions, symmetry_noise=0.03)
axes = po.figures.breakup_probability(collisions.table, fit)

# %%
# The collisions themselves: those that broke, all of them, and those that did not, with the
# fitted line and the paper's.

panels = po.figures.separated_outcomes(collisions.table, fit)
