"""Models as dictionaries: what an actuator's or a scenario's file says, key by key."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any, Union

from . import _core
from ._record import Record, parsed

#: A model: a preset's name, a file, or a dictionary with the keys of a file.
Model = Union[str, "os.PathLike[str]", Mapping[str, Any]]


def presets() -> Record:
    """Names of the scenarios, robots and actuators that come with the package."""
    scenarios, robots, actuators = _core.preset_names()
    return Record(scenarios=scenarios, robots=robots, actuators=actuators)


def actuator(name: str | os.PathLike[str]) -> Record:
    """An actuator by its preset's name or file, as a dictionary that may be changed and given as a model."""
    return parsed(_core.actuator_model(os.fspath(name)))


def scenario(name: str | os.PathLike[str]) -> Record:
    """A leg's scenario by its preset's name or file, as a dictionary that may be changed and given as a model."""
    return parsed(_core.scenario_model(os.fspath(name)))


def split(model: Model | None) -> tuple[str | None, str | None]:
    """A model as the extension takes it: its name or file, or its dictionary as JSON."""
    if model is None:
        return None, None
    if isinstance(model, Mapping):
        return None, json.dumps(model, default=_plain, allow_nan=False)
    return os.fspath(model), None


def _plain(value: Any) -> Any:
    """Numbers and arrays of NumPy as Python's own."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no place in a model")
