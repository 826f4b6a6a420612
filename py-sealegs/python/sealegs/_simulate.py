"""Simulated runs of a leg and of an actuator on a bench."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import nullcontext
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core, _files, _frames, _models
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

    Ctrl-C stops it. Raises :class:`InputError` naming the key, or :class:`SimulationError`.
    """
    name, json = _models.split(scenario)
    overrides = [f"{key}={_literal(value)}" for key, value in (changes or {}).items()]
    with nullcontext() if recording is None else _files.whole(recording) as part:
        channels, result = _core.simulate_leg(name, json, overrides, part)
    return Run(channels, parsed(result))


def simulate_bench(
    actuator: _models.Model,
    *,
    time_s: Any,
    bench: str = "locked",
    rig: Mapping[str, float] | None = None,
    spring: str | None = None,
    hold: str = "zero-order",
    step_s: float | None = None,
    **command: Any,
) -> Run:
    """Runs an actuator on a bench from rest.

    :param actuator: a preset's name (see :func:`presets`), a file, or a dictionary of :func:`actuator`.
    :param time_s: time stamps, s, shape ``(samples,)``, increasing.
    :param bench: ``"locked"`` (both links held), ``"pendulum"`` (the output turns a lever with a weight) or ``"free"``
        (the output moves a load).
    :param rig: the bench's own numbers, as in :meth:`Campaign.from_frames`; without them a pendulum has 4 kg at
        0.300 m on a lever of 0.0725 m.
    :param spring: a setting of the spring, as the actuator takes it (``"compliant"``, ``"80mm"``).
    :param hold: what the command does between samples: ``"zero-order"``, ``"linear"`` or ``"band-limited"``.
    :param step_s: the integrator's greatest step, s.
    :param command: the command by its channel, shape ``(samples,)``: ``current_a=`` (A), ``motor_force_n=`` (N),
        ``motor_torque_nm=`` (N m), ``voltage_v=`` (V) or ``position_rad=`` (rad), as the actuator takes it.

    Raises :class:`InputError` for an unknown actuator or command, or a column of another length.
    """
    if len(command) != 1:
        raise TypeError("give one command: current_a=, motor_force_n=, motor_torque_nm=, voltage_v= or position_rad=")
    ((channel, values),) = command.items()
    given = _frames.columns({"time_s": time_s, channel: values})
    numbers = [(key, float(number)) for key, number in (rig or {}).items()]
    name, json = _models.split(actuator)
    channels, notes = _core.simulate_bench(
        name, json, bench, numbers, channel, given["time_s"], given[channel], spring, hold, step_s
    )
    return Run(channels, Record(notes=notes))


def _literal(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return value
    return repr(value.item() if hasattr(value, "item") else value)
