"""Simulated runs of a leg and of an actuator on a bench."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core, _frames, _models
from ._record import Record, parsed


class Run:
    """A simulated run: its channels as arrays, and what was seen at every step."""

    def __init__(self, channels: dict[str, NDArray[np.float64]], result: Record) -> None:
        #: Channels by name, float64 of shape ``(samples,)``, ``time_s`` (s) first; a name's ending is its unit.
        self.channels = channels
        #: A leg's peaks, events and energy balance, or the remarks of a bench, with the keys of ``sealegs run --json``.
        self.result = result

    def __getitem__(self, channel: str) -> NDArray[np.float64]:
        return self.channels[channel]

    @property
    def time_s(self) -> NDArray[np.float64]:
        """Time stamps, s, shape ``(samples,)``."""
        return self.channels["time_s"]

    def frame(self, library: str | None = None) -> Any:
        """The channels as a frame of ``"pandas"`` or ``"polars"``; without a name of the one in use."""
        return _frames.frame(self.channels, library)

    def __repr__(self) -> str:
        return f"<Run: {len(self.time_s)} samples of {len(self.channels) - 1} channels, {self.time_s[-1]:.3g} s>"


def simulate(
    scenario: _models.Model,
    changes: Mapping[str, Any] | None = None,
    *,
    recording: str | os.PathLike[str] | None = None,
) -> Run:
    """Runs a leg's scenario to its end, or until its state is no longer finite (``result.stopped`` then says why).

    :param scenario: a preset's name (see :func:`presets`), a file, or a dictionary of :func:`scenario`.
    :param changes: other values of its keys, dotted: ``{"start.drop_height_m": 0.05}``.
    :param recording: also writes a Rerun recording there.

    Ctrl-C stops it.
    """
    name, json = _models.split(scenario)
    overrides = [f"{key}={_literal(value)}" for key, value in (changes or {}).items()]
    path = None if recording is None else os.fspath(recording)
    channels, result = _core.simulate_leg(name, json, overrides, path)
    return Run(channels, parsed(result))


def simulate_bench(
    actuator: _models.Model,
    *,
    time_s: Any,
    bench: str = "locked",
    spring: str | None = None,
    hold: str = "zero-order",
    step_s: float | None = None,
    **command: Any,
) -> Run:
    """Runs an actuator on a bench from rest.

    :param actuator: a preset's name (see :func:`presets`), a file, or a dictionary of :func:`actuator`.
    :param time_s: time stamps, s, shape ``(samples,)``, increasing.
    :param bench: ``"locked"`` (both links held) or ``"pendulum"`` (the screw turns a lever with a weight).
    :param spring: a setting of the spring, as the actuator takes it (``"compliant"``, ``"80mm"``).
    :param hold: what the command does between samples: ``"zero-order"``, ``"linear"`` or ``"band-limited"``.
    :param step_s: the integrator's greatest step, s.
    :param command: the command by its channel, shape ``(samples,)``: ``current_a=`` (A), ``motor_force_n=`` (N) or
        ``motor_torque_nm=`` (N m).
    """
    if len(command) != 1:
        raise TypeError("give one command: current_a=, motor_force_n= or motor_torque_nm=")
    ((channel, values),) = command.items()
    given = _frames.columns({"time_s": time_s, channel: values})
    name, json = _models.split(actuator)
    channels, notes = _core.simulate_bench(
        name, json, bench, channel, given["time_s"], given[channel], spring, hold, step_s
    )
    return Run(channels, Record(notes=notes))


def _literal(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value.item() if hasattr(value, "item") else value) if not isinstance(value, str) else value
