"""What the tests share: the shipped bench campaign, its tables, and one diagnosis of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import sealegs
import tomllib

CAMPAIGNS = Path(__file__).parents[2] / "assets" / "campaigns"
BENCH = CAMPAIGNS / "bench-knee"


def table(file: Path) -> dict[str, np.ndarray]:
    """A CSV's columns, read without the package."""
    names = file.read_text().splitlines()[0].split(",")
    values = np.loadtxt(file, delimiter=",", skiprows=1)
    return {name: np.ascontiguousarray(values[:, i]) for i, name in enumerate(names)}


@pytest.fixture(scope="session")
def description() -> dict:
    return tomllib.loads((BENCH / "campaign.toml").read_text())


@pytest.fixture(scope="session")
def tables(description: dict) -> dict[str, dict[str, dict[str, np.ndarray]]]:
    """The tables of the bench by role and run."""
    roles: dict = {"fit": {}, "holdout": {}}
    for run in description["run"]:
        roles[run["role"]][run["file"]] = table(BENCH / run["file"])
    return roles


@pytest.fixture(scope="session")
def hidden() -> list[str]:
    """What is hidden in the bench, by the file that only tests read."""
    answers = tomllib.loads((CAMPAIGNS / "answers.toml").read_text())
    return list(answers["bench-knee"]["effects"])


@pytest.fixture(scope="session")
def read() -> sealegs.Campaign:
    return sealegs.Campaign.read(BENCH)


@pytest.fixture(scope="session")
def verdict(read: sealegs.Campaign) -> sealegs.Diagnosis:
    return sealegs.diagnose(read, progress=False)


def built(description: dict, tables: dict, **changes) -> sealegs.Campaign:
    """The bench's campaign from tables in memory."""
    given = dict(
        bench=description["bench"],
        model=description["actuator"],
        fit=tables["fit"],
        holdout=tables["holdout"],
        noise_std=description["noise_std"],
        sample_rate_hz=description["sample_rate_hz"],
    )
    return sealegs.Campaign.from_frames(description["name"], **{**given, **changes})
