"""The command ``sealegs``, the same program as the Rust one: ``python -m sealegs tour``."""

from __future__ import annotations

import sys

from . import _core


def main() -> int:
    """Runs the program with this process's arguments; returns its exit status."""
    return _core.main(["sealegs", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
