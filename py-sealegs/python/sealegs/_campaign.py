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
        span_s: Mapping[str, tuple[float | None, float | None]] | None = None,
        hold: str = "zero-order",
        sample_rate_hz: float | None = None,
    ) -> Campaign:
        """A campaign of tables in memory; no file is written or read.

        :param name: its name.
        :param bench: ``"locked"``, ``"pendulum"`` or ``"leg"``.
        :param model: the actuator's preset or file, for a leg the scenario's.
        :param fit: the runs that are fitted and selected on, by name. Each is a pandas or polars frame, a mapping of
            names to arrays of shape ``(rows,)``, or a structured array, with at least 16 rows: ``time_s`` (s, strictly
            increasing), one input (``current_a`` in A, ``motor_force_n`` in N or ``motor_torque_nm`` in N m; a bench
            needs exactly one), and outputs (``force_1_n``, ``motor_angle_rad``, ...). A leg's columns carry their
            place: ``knee.angle_rad``, ``knee.force_1_n``.
        :param holdout: the runs that judge once, at the end.
        :param noise_std: one standard deviation of a channel's noise, in its unit; otherwise it is estimated.
        :param inputs: for a leg, the columns that are commands.
        :param scenarios: for a leg, runs that have another scenario than ``model``.
        :param span_s: first and last time stamp of the rows that count, by run, s.
        :param hold: what the command does between samples: ``"zero-order"``, ``"linear"`` or ``"band-limited"``.
        :param sample_rate_hz: the nominal rate; a clock that differs from it is remarked on in :attr:`notes`.

        Raises :class:`InputError` naming run, row and column.
        """
        runs = []
        for role, tables in (("fit", fit), ("holdout", holdout or {})):
            for run, table in tables.items():
                columns = list(_frames.columns(table).items())
                from_s, to_s = (span_s or {}).get(run, (None, None))
                runs.append((str(run), role, (scenarios or {}).get(run), columns, (from_s, to_s)))
        noise = [(channel, float(std)) for channel, std in (noise_std or {}).items()]
        return cls(_core.Campaign.build(name, bench, model, runs, noise, list(inputs), hold, sample_rate_hz))

    @property
    def name(self) -> str:
        """Its name."""
        return self._core.name

    @property
    def bench(self) -> str:
        """``"locked"``, ``"pendulum"`` or ``"leg"``."""
        return self._core.bench

    @property
    def model(self) -> str:
        """The actuator that it names; for a leg the scenario."""
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
