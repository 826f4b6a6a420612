"""Columns of whatever holds them: pandas, polars, dictionaries and structured arrays of NumPy, and back."""

from __future__ import annotations

import importlib
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Libraries whose frames come and go.
KNOWN = ("pandas", "polars")


def columns(frame: Any) -> dict[str, NDArray[np.float64]]:
    """The columns of a table as contiguous float64 arrays of shape ``(rows,)``.

    ``frame`` is a pandas or polars frame, a mapping of names to arrays, or a structured array. Arrays that are float64
    and contiguous already are not copied here.
    """
    if isinstance(frame, np.ndarray) and frame.dtype.names is not None:
        names, column = frame.dtype.names, frame.__getitem__
    elif hasattr(frame, "columns") and hasattr(frame, "__getitem__"):
        names, column = list(frame.columns), frame.__getitem__
    elif hasattr(frame, "keys"):
        names, column = list(frame.keys()), frame.__getitem__
    else:
        raise TypeError(f"{type(frame).__name__} holds no named columns: give a frame, a mapping or a structured array")
    return {str(name): _floats(str(name), column(name)) for name in names}


def _floats(name: str, values: Any) -> NDArray[np.float64]:
    if hasattr(values, "to_numpy"):
        values = values.to_numpy()
    try:
        array = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise TypeError(f"column '{name}': {error}") from None
    if array.ndim != 1:
        raise TypeError(f"column '{name}' has shape {array.shape}; one value a row is needed")
    return array


def frame(data: dict[str, NDArray[np.float64]], library: str | None = None) -> Any:
    """A frame of these columns: of ``library`` (``"pandas"`` or ``"polars"``), else of the one in use or installed."""
    if library not in (None, *KNOWN):
        raise ValueError(f"'{library}' is no library of frames that is known here: {', '.join(KNOWN)}")
    # The one that the caller has imported goes first.
    for name in [library] if library else sorted(KNOWN, key=lambda name: name not in sys.modules):
        try:
            module = importlib.import_module(name)
        except ImportError:
            continue
        return module.DataFrame(data)
    raise ImportError(f"{library or 'pandas or polars'} is needed for a frame, and is not installed")
