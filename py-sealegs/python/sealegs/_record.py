"""JSON objects with attributes."""

from __future__ import annotations

import json
from typing import Any


class Record(dict[str, Any]):
    """A JSON object: a dictionary whose keys are attributes as well (``verdict.after.holdout_error``)."""

    __slots__ = ()

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"no '{name}'; there is {', '.join(self)}") from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self]


def parsed(text: str) -> Record:
    """The text of a JSON object, with every object in it as a :class:`Record`."""
    record: Record = json.loads(text, object_hook=Record)
    return record
