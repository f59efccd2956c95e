"""The paper again: every figure and number that can be remade, ours beside the paper's."""

from pinchoff.paper.make import Reproduction, reproduce

__all__ = ["Reproduction", "reproduce"]
