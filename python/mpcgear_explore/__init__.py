"""Searches over designs: which to try next by Optuna, the work spread by Dask, the designs by `mpcgear`.

Started by `mpcgear explore`, which reads and checks the study file first.
"""
