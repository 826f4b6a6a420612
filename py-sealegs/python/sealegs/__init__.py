"""Legs with linear series elastic actuators: simulate, compare with logs, find the missing physical effect, add it.

>>> import sealegs
>>> campaign = sealegs.Campaign.read("knee-bench")          # or sealegs.Campaign.from_frames(...)
>>> verdict = sealegs.diagnose(campaign)                    # doctest: +SKIP
>>> verdict.effects, verdict.after.holdout_error            # doctest: +SKIP
>>> better = sealegs.add(verdict.effects, campaign)         # doctest: +SKIP
>>> sealegs.compare(campaign, model=better.model)           # doctest: +SKIP

Numbers are float64 in SI units and radians; a column's name ends in its unit (``force_1_n``, ``motor_angle_rad``). A
residual is measured minus predicted, in units of the channel's noise.
"""

from __future__ import annotations

from ._campaign import Campaign
from ._core import InputError, SealegsError, SimulationError, __version__
from ._models import actuator, presets, scenario
from ._record import Record
from ._results import Addition, Comparison, Diagnosis, add, compare, diagnose
from ._simulate import Run, simulate, simulate_bench

__all__ = [
    "Addition",
    "Campaign",
    "Comparison",
    "Diagnosis",
    "InputError",
    "Record",
    "Run",
    "SealegsError",
    "SimulationError",
    "__version__",
    "actuator",
    "add",
    "compare",
    "diagnose",
    "presets",
    "scenario",
    "simulate",
    "simulate_bench",
]
