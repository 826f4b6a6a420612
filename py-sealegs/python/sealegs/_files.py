"""Files that are whole or not there at all: written beside their place, then renamed."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress


@contextmanager
def whole(path: str | os.PathLike[str]) -> Iterator[str]:
    """The path to write to, ``<path>.part``; it is renamed to ``path`` if nothing is raised, and removed otherwise."""
    part = os.fspath(path) + ".part"
    try:
        yield part
        os.replace(part, path)
    except BaseException:
        with suppress(FileNotFoundError):
            os.remove(part)
        raise
