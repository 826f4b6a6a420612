"""Progress of long work by tqdm, where that is installed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Optional, Union

#: Told what is being tried (``None`` where nothing new is), and the simulations so far.
Tell = Callable[[Optional[str], int], None]
#: ``True``: a bar if tqdm is installed; ``False``: silence; or a function of one's own.
Progress = Union[bool, Tell]


@contextmanager
def telling(progress: Progress) -> Iterator[Tell | None]:
    """What the work is to call; a bar of tqdm is closed in the end."""
    if progress is False:
        yield None
        return
    if callable(progress):
        yield progress
        return
    try:
        from tqdm.auto import tqdm  # type: ignore[import-untyped]
    except ImportError:
        yield None
        return
    # How many simulations a search takes is not known beforehand.
    with tqdm(bar_format="{desc} {n_fmt} simulations, {elapsed}") as bar:

        def tell(what: str | None, simulations: int) -> None:
            if what is not None:
                bar.set_description_str(what, refresh=False)
            bar.update(simulations - bar.n)

        yield tell
