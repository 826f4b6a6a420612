"""The extension module; use the package."""

from collections.abc import Callable
from typing import Any, final, type_check_only

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Campaign",
    "InputError",
    "SealegsError",
    "SimulationError",
    "actuator_model",
    "preset_names",
    "scenario_model",
    "Addition",
    "Comparison",
    "Diagnosis",
    "add",
    "better",
    "compare",
    "diagnose",
    "model_file",
    "plan",
    "simulate_bench",
    "simulate_leg",
    "main",
    "__version__",
]

__version__: str

_Tell = Callable[[str | None, int], None] | None
_Columns = dict[str, NDArray[np.float64]]

class SealegsError(Exception): ...
class InputError(SealegsError): ...
class SimulationError(SealegsError): ...

@final
class Campaign:
    name: str
    bench: str
    model: str
    notes: list[str]
    noise_std: list[tuple[str, float]]
    noise_floor: float
    runs: list[tuple[str, str]]
    @staticmethod
    def read(path: str) -> Campaign: ...
    @staticmethod
    def build(
        name: str,
        bench: str,
        model: str,
        runs: list[
            tuple[
                str,
                str,
                str | None,
                str | None,
                list[tuple[str, float]],
                list[tuple[str, NDArray[np.float64]]],
                tuple[float | None, float | None],
            ]
        ],
        noise_std: list[tuple[str, float]],
        inputs: list[str],
        hold: str,
        sample_rate_hz: float | None,
        window_s: float | None,
        gravity_compensated: bool,
    ) -> Campaign: ...
    def columns(self, run: str) -> _Columns: ...

@type_check_only
class _Result:
    sentence: str
    def to_json(self) -> str: ...
    def to_text(self) -> str: ...
    def to_html(self) -> str: ...
    def curves(self) -> list[dict[str, Any]]: ...
    def write_recording(self, path: str) -> None: ...

@final
class Comparison(_Result): ...

@final
class Diagnosis(_Result): ...

@final
class Addition(_Result): ...

def compare(
    campaign: Campaign,
    model: str | None,
    model_json: str | None,
    own_effects: list[str],
    as_is: bool,
    tell: _Tell,
) -> Comparison: ...
def diagnose(
    campaign: Campaign,
    model: str | None,
    model_json: str | None,
    own_effects: list[str],
    how: tuple[bool, float | None],
    tell: _Tell,
) -> Diagnosis: ...
def add(
    effects: list[str],
    campaign: Campaign,
    model: str | None,
    model_json: str | None,
    own_effects: list[str],
    tell: _Tell,
) -> Addition: ...
def plan(diagnosis: Diagnosis, folder: str) -> str | None: ...
def better(diagnosis: Diagnosis) -> Addition | None: ...
def model_file(addition: Addition, folder: str, unit: str | None = None) -> tuple[str, str]: ...
def preset_names() -> tuple[list[str], list[str], list[str]]: ...
def actuator_model(name: str) -> str: ...
def scenario_model(name: str) -> str: ...
def simulate_leg(
    scenario: str | None, scenario_json: str | None, overrides: list[str], recording: str | None
) -> tuple[_Columns, str]: ...
def simulate_bench(
    actuator: str | None,
    actuator_json: str | None,
    bench: str,
    rig: list[tuple[str, float]],
    channel: str,
    time_s: NDArray[np.float64],
    command: NDArray[np.float64],
    spring: str | None,
    hold: str,
    step_s: float | None,
) -> tuple[_Columns, list[str]]: ...
def main(arguments: list[str]) -> int: ...
