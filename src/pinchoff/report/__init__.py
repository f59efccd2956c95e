"""Reports: pages that open without a network, with the figures and numbers of a piece of work."""
