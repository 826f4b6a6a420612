"""The figure of a result: measured, before and after in time, with the residuals beside them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._record import Record

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Channels that a figure shows unless others are asked for.
SHOWN = 4

#: Colours of Okabe and Ito, which colour-blind readers tell apart: measured, before, after.
INK, VERMILLION, BLUE = "#000000", "#d55e00", "#0072b2"


def of(curves: list[Record], title: str, run: str | None, channels: list[str] | None) -> Figure:
    """One row for each channel: in time on the left, residuals on the right."""
    try:
        from ._shown import ShownFigure
    except ImportError:
        raise ImportError("figures need matplotlib: pip install sealegs[notebook]") from None
    shown = _run(curves, run)
    measured = [name for name, curve in shown.channels.items() if len(curve.measured)]
    names = channels or sorted(measured, key=lambda name: -_error(shown.channels[name]))[:SHOWN]
    unknown = [name for name in names if name not in measured]
    if unknown:
        raise KeyError(f"no channel {', '.join(unknown)}; the run has {', '.join(measured)}")
    figure = ShownFigure(figsize=(10, 1 + 2.2 * len(names)), layout="constrained")
    axes = figure.subplots(len(names), 2, sharex=True, squeeze=False)
    for (left, right), name in zip(axes, names):
        curve = shown.channels[name]
        unit = f", {curve.unit}" if curve.unit else ""
        left.set_ylabel(name + unit)
        right.set_ylabel("residual" + unit)
        for values, color, label in _models(curve):
            left.plot(shown.time_s, values, color=color, linewidth=1, label=label)
            right.plot(shown.time_s, curve.measured - values, color=color, linewidth=0.8, label=label)
        left.plot(shown.time_s, curve.measured, color=INK, linewidth=0.6, label="measured")
    for axis in axes[-1]:
        axis.set_xlabel("time, s")
    axes[0][0].legend(loc="best", fontsize="small")
    figure.suptitle(f"{title}\n{shown.name}", fontsize="medium", wrap=True)
    return figure


def _models(curve: Record) -> list[tuple[Any, str, str]]:
    models = [(curve.before, VERMILLION, "before"), (curve.after, BLUE, "after")]
    return [(values, color, label) for values, color, label in models if values is not None]


def _error(curve: Record) -> float:
    """Root mean square residual before, as a share of the channel's own variation."""
    if curve.before is None or not len(curve.measured):
        return 0.0
    size = float(np.nanstd(curve.measured)) or 1.0
    return float(np.sqrt(np.nanmean((curve.measured - curve.before) ** 2))) / size


def _run(curves: list[Record], part: str | None) -> Record:
    if part is not None:
        found = [run for run in curves if part in run.name]
        if not found:
            raise KeyError(f"no run '{part}'; there is {', '.join(run.name for run in curves)}")
        return found[0]
    holdout = [run for run in curves if "(holdout)" in run.name] or curves
    return max(holdout, key=lambda run: max((_error(c) for c in run.channels.values()), default=0.0))
