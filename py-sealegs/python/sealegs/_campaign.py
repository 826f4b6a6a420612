"""Campaigns: recorded runs with what they were recorded on."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core, _frames


class Campaign:
    """Recorded runs of a bench or a leg, and the model that they are compared with.

    Made by :meth:`read` from files, by :meth:`from_frames` from tables in memory.
    """

    def __init__(self, core: _core.Campaign) -> None:
        self._core = core

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Campaign:
        """Reads a campaign's folder, or its ``campaign.toml``.

        Raises :class:`InputError` for bad input, naming file, line and column.
        """
        return cls(_core.Campaign.read(os.fspath(path)))

    @classmethod
    def from_frames(
        cls,
        name: str,
        *,
        bench: str,
        model: str,
        fit: Mapping[str, Any],
        holdout: Mapping[str, Any] | None = None,
        noise_std: Mapping[str, float] | None = None,
        inputs: Iterable[str] = (),
        scenarios: Mapping[str, str] | None = None,
        units: Mapping[str, str] | None = None,
        rig: Mapping[str, float] | None = None,
        rigs: Mapping[str, Mapping[str, float]] | None = None,
        span_s: Mapping[str, tuple[float | None, float | None]] | None = None,
        hold: str = "zero-order",
        sample_rate_hz: float | None = None,
        window_s: float | None = None,
        gravity_compensated: bool = False,
    ) -> Campaign:
        """A campaign of tables in memory; no file is written or read.

        :param name: its name.
        :param bench: ``"locked"``, ``"pendulum"``, ``"free"``, ``"robot"`` or ``"leg"``.
        :param model: the actuator's preset or file, for a leg the scenario's, for a robot its URDF or model file.
        :param fit: the runs that are fitted and selected on, by name. Each is a pandas or polars frame, a mapping of
            names to arrays of shape ``(rows,)``, or a structured array, with at least 16 rows: ``time_s`` (s, strictly
            increasing), one input (``current_a`` in A, ``motor_force_n`` in N, ``motor_torque_nm`` or
            ``joint_torque_nm`` in N m, ``voltage_v`` in V, ``position_rad`` in rad; a bench needs exactly one), and
            outputs (``force_1_n``, ``motor_angle_rad``, ...). Columns of a leg and of a robot carry their place:
            ``knee.angle_rad``, ``knee.force_1_n``.
        :param holdout: the held-out runs, scored once, at the end.
        :param noise_std: one standard deviation of a channel's noise, in its unit; otherwise it is estimated.
        :param inputs: for a leg, the columns that are commands.
        :param scenarios: for a leg, runs that have another scenario than ``model``.
        :param units: which of several units of a kind each run was recorded on (``"left"``), by run: every run must then
            have one. Each unit has values of its own; the effects are shared.
        :param rig: the bench's own numbers: of a pendulum ``mass_kg``, ``length_m``, ``rod_mass_kg`` and ``arm_m``, of
            the bench ``"free"`` ``mass_kg`` or ``inertia_kg_m2`` (kg m^2), of both ``servo_gain`` (a ratio).
        :param rigs: runs whose numbers differ from ``rig``, by run.
        :param span_s: first and last time stamp of the rows that count, by run, s.
        :param hold: what the command does between samples: ``"zero-order"``, ``"linear"`` or ``"band-limited"``.
        :param sample_rate_hz: the nominal rate; a clock that differs from it is remarked on in :attr:`notes`.
        :param window_s: of the benches ``"free"`` and ``"robot"``, runs are cut into pieces of so many seconds, each of
            which begins at the measured state: a joint under a force drifts away in open loop.
        :param gravity_compensated: of the bench ``"robot"``, its controller adds the torques that hold it against gravity
            to those that the runs command, as libfranka's does.

        Raises :class:`InputError` naming run, row and column.
        """
        _known_runs({"scenarios": scenarios, "units": units, "rigs": rigs, "span_s": span_s}, [*fit, *(holdout or {})])
        runs = []
        for role, tables in (("fit", fit), ("holdout", holdout or {})):
            for run, table in tables.items():
                columns = list(_frames.columns(table).items())
                from_s, to_s = (span_s or {}).get(run, (None, None))
                numbers = {**(rig or {}), **(rigs or {}).get(run, {})}
                own = [(key, float(number)) for key, number in numbers.items()]
                scenario, unit = ((said or {}).get(run) for said in (scenarios, units))
                runs.append((str(run), role, scenario, unit, own, columns, (from_s, to_s)))
        noise = [(channel, float(std)) for channel, std in (noise_std or {}).items()]
        built = _core.Campaign.build(
            name, bench, model, runs, noise, list(inputs), hold, sample_rate_hz, window_s, gravity_compensated
        )
        return cls(built)

    @property
    def name(self) -> str:
        """Its name."""
        return self._core.name

    @property
    def bench(self) -> str:
        """``"locked"``, ``"pendulum"``, ``"free"``, ``"robot"`` or ``"leg"``."""
        return self._core.bench

    @property
    def model(self) -> str:
        """The actuator that it names; for a leg the scenario, for a robot its URDF."""
        return self._core.model

    @property
    def notes(self) -> list[str]:
        """What a person should know of the data: unknown columns, irregular time."""
        return self._core.notes

    @property
    def noise_std(self) -> dict[str, float]:
        """One standard deviation of each channel's noise, in its unit: what residuals are divided by."""
        return dict(self._core.noise_std)

    @property
    def noise_floor(self) -> float:
        """The error below which no model can be expected to come, in noise units; at least 1."""
        return self._core.noise_floor

    @property
    def runs(self) -> dict[str, str]:
        """Each run's role, ``"fit"`` or ``"holdout"``, by its name."""
        return dict(self._core.runs)

    def columns(self, run: str) -> dict[str, NDArray[np.float64]]:
        """Copies of a run's columns, float64 of shape ``(rows,)``, ``time_s`` first."""
        return self._core.columns(run)

    def frame(self, run: str, library: str | None = None) -> Any:
        """A run as a frame of ``"pandas"`` or ``"polars"``; without a name of the one in use."""
        return _frames.frame(self.columns(run), library)

    def __repr__(self) -> str:
        roles = list(self.runs.values())
        return (
            f"<Campaign {self.name!r}: {self.model} on the {self.bench} bench, "
            f"{roles.count('fit')} fit and {roles.count('holdout')} holdout runs>"
        )


def _known_runs(said: Mapping[str, Mapping[str, Any] | None], runs: list[str]) -> None:
    """Refuses what is said of a run that is not there: a slip of the pen would change nothing without a word."""
    for argument, by_run in said.items():
        for run in by_run or {}:
            if run not in runs:
                there = ", ".join(map(str, runs)) or "none"
                raise _core.InputError(f"{argument} names a run '{run}'; there is {there}")
