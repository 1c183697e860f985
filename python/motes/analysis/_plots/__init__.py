"""Plots of one run (`Plots`) and of many (`RunsPlots`)."""

from .many_runs import RunsPlots
from .one_run import Plots

__all__ = ["Plots", "RunsPlots"]
