"""Comparison, diagnosis and addition, with the keys of their JSON as attributes; a notebook shows the report."""

from __future__ import annotations

import html
import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from . import _core, _figure, _files, _models, _progress
from ._campaign import Campaign
from ._record import Record, parsed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Core = TypeVar("Core", bound="_core._Result")


class Result(Generic[Core]):
    """What the three results have in common. Attributes are the keys of :meth:`to_json`."""

    _core: Core
    _json: Record

    def __init__(self, core: Core) -> None:
        self._core = core
        self._json = parsed(core.to_json())

    def __getattr__(self, name: str) -> Any:
        # Copying and unpickling look for names before there is a result to look into.
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self._json, name)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._json]

    @property
    def sentence(self) -> str:
        """The result in one sentence with its numbers."""
        return self._core.sentence

    def to_dict(self) -> Record:
        """The numbers, as ``--json`` of the program's verb writes them."""
        return self._json

    def to_json(self) -> str:
        """The same as text."""
        return self._core.to_json()

    def to_text(self) -> str:
        """What the program prints."""
        return self._core.to_text()

    def to_html(self) -> str:
        """The report as one HTML file without anything outside it."""
        return self._core.to_html()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the report (``.html``), the numbers (``.json``), the text (``.txt``) or a Rerun recording (``.rrd``).

        The file is whole or not there. Raises :class:`InputError` for another ending.
        """
        ending = os.path.splitext(os.fspath(path))[1]
        texts = {".html": self.to_html, ".json": self.to_json, ".txt": self.to_text}
        if ending == ".rrd":
            with _files.whole(path) as part:
                self._core.write_recording(part)
        elif ending in texts:
            text = texts[ending]()
            with _files.whole(path) as part, open(part, "w", encoding="utf-8") as file:
                file.write(text)
        else:
            raise _core.InputError(f"{path}: the ending must be .rrd, {', '.join(texts)}")

    def curves(self) -> list[Record]:
        """Every run with its ``name``, ``time_s`` (s, shape ``(rows,)``) and ``channels``: by name their ``unit`` and
        ``measured``, ``before`` and ``after``, in that unit, shape ``(rows,)``; ``after`` is ``None`` where there is no
        second model."""
        runs = self._core.curves()
        for run in runs:
            run["channels"] = Record({name: Record(curve) for name, curve in run["channels"].items()})
        return [Record(run) for run in runs]

    def figure(self, run: str | None = None, channels: Iterable[str] | None = None) -> Figure:
        """Measured, before and after in time, and the residuals beside them, by matplotlib.

        :param run: part of a run's name; without it the holdout run with the greatest error is shown.
        :param channels: the channels; without them the four that are worst before.
        """
        return _figure.of(self.curves(), self.sentence, run, None if channels is None else list(channels))

    def _repr_html_(self) -> str:
        page = html.escape(self.to_html(), quote=True)
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 80vh; border: 1px solid #ccc"></iframe>'

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self.campaign!r}: {self.sentence}>"


class Comparison(Result[_core.Comparison]):
    """Where a model fails on a campaign, and by how much.

    ``given`` and ``base`` have the errors as given and refitted, in units of the noise; ``channels``, ``worst`` and
    ``structure`` say where they are.
    """


class Diagnosis(Result[_core.Diagnosis]):
    """Which effect a model lacks.

    ``verdict`` and ``effects`` answer; ``base`` and ``after`` have errors (in units of the noise) and parameters
    without and with the effects; ``indistinguishable``, ``ladder``, ``missing_signals``, ``ranking`` and
    ``next_experiment`` say how sure that is.
    """

    def plan(self, folder: str | os.PathLike[str] = ".") -> str | None:
        """The next experiment as the text of a file that will lie in ``folder``; ``None`` where none is proposed.

        It is the CSV of an input (``time_s`` and the command's column), or a leg's scenario.
        """
        return _core.plan(self._core, os.fspath(folder))

    def better(self) -> "Addition | None":
        """The model with the effects that are named, at the values of the verdict; ``None`` where nothing is named.

        What :func:`add` gives, without another fit.
        """
        better = _core.better(self._core)
        return None if better is None else Addition(better)


class Addition(Result[_core.Addition]):
    """A model with effects added: ``effects``, ``base``, ``after``, and the model itself."""

    @property
    def model(self) -> Record:
        """The better model as a dictionary, which may be given as a model."""
        return parsed(_core.model_file(self._core, ".")[1])

    def model_file(self, folder: str | os.PathLike[str] = ".", unit: str | None = None) -> str:
        """The better model as the text of a file that will lie in ``folder``; it says where its numbers come from.

        Of a campaign of several units each has a file of its own: ``unit`` says whose.
        """
        return _core.model_file(self._core, os.fspath(folder), unit)[0]


def compare(
    campaign: Campaign,
    model: _models.Model | None = None,
    *,
    as_is: bool = False,
    own_effects: Iterable[str | os.PathLike[str]] = (),
    progress: _progress.Progress = True,
) -> Comparison:
    """Compares a campaign with its model, after the model's own parameters and the sensors' gains were refitted.

    :param model: another model in place of the campaign's: a preset's name, a file, or a dictionary.
    :param as_is: without the refit.
    :param own_effects: files of effects of one's own.
    :param progress: a bar if tqdm is installed; ``False`` for silence, or a function that is called with what is tried
        and the simulations so far.

    Ctrl-C stops it. Raises :class:`InputError` or :class:`SimulationError`.
    """
    with _progress.telling(progress) as tell:
        return Comparison(_core.compare(campaign._core, *_models.split(model), _paths(own_effects), as_is, tell))


def diagnose(
    campaign: Campaign,
    model: _models.Model | None = None,
    *,
    own_effects: Iterable[str | os.PathLike[str]] = (),
    force: bool = False,
    at_most: float | None = None,
    progress: _progress.Progress = True,
) -> Diagnosis:
    """Finds the physical effect that a model lacks, or says that none is missing or none is known.

    The campaign needs fit and holdout runs. A bench takes seconds to minutes, a leg minutes. Ctrl-C stops it; ``at_most``
    ends its search with what was found until then.

    :param force: begin although a column is not what its name says (a flipped sign, degrees for radians), which is an
        :class:`InputError` otherwise.
    :param at_most: seconds after which the search ends and the best set that was found is judged; the verdict says so.

    Other arguments are those of :func:`compare`. Raises :class:`InputError` or :class:`SimulationError`.
    """
    with _progress.telling(progress) as tell:
        core = _core.diagnose(campaign._core, *_models.split(model), _paths(own_effects), (force, at_most), tell)
        return Diagnosis(core)


def add(
    effects: str | Iterable[str],
    campaign: Campaign,
    model: _models.Model | None = None,
    *,
    own_effects: Iterable[str | os.PathLike[str]] = (),
    progress: _progress.Progress = True,
) -> Addition:
    """Adds effects to a model and fits everything together.

    :param effects: ids (``"coulomb-friction"``, ``"knee/coulomb-friction"``, ``"backlash+cogging"``) or files of one's
        own.

    Other arguments are those of :func:`compare`. Ctrl-C stops it. Raises :class:`InputError` for an unknown effect,
    with those that the model can have, or :class:`SimulationError`.
    """
    ids = [effects] if isinstance(effects, str) else list(effects)
    with _progress.telling(progress) as tell:
        return Addition(_core.add(ids, campaign._core, *_models.split(model), _paths(own_effects), tell))


def _paths(files: Iterable[str | os.PathLike[str]]) -> list[str]:
    return [os.fspath(file) for file in files]
