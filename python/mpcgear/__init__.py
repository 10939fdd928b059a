"""Designs multi-point conjugation gears from Python: a thin layer over the `mpcgear` program."""

from mpcgear.program import BadInput, Infeasible, MpcgearError, find
from mpcgear.results import Design, Mesh, design

__all__ = ["BadInput", "Design", "Infeasible", "Mesh", "MpcgearError", "design", "find"]
