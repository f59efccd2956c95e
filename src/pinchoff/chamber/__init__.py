"""The microfluidic device: one geometry, from which masks, checks, flow and positions follow."""

from pinchoff.chamber.design import Chamber as Chamber
