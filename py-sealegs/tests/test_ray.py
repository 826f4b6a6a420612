"""Mysteries on Ray, with two workers, are those of one machine alone, to the last bit."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[1] / "examples" / "mysteries_on_ray.py"

#: Three mysteries with the shortest runs: seconds each.
KIND = ["--bench", "locked", "--level", "easy", "--duration", "3"]


def run(*command: str) -> str:
    done = subprocess.run([sys.executable, *command], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_two_workers_of_ray_give_the_serial_result_bit_for_bit(tmp_path):
    pytest.importorskip("ray", reason='Ray is not installed: pip install "sealegs[ray]"')
    serial, parallel, jobs = (tmp_path / name for name in ("serial.json", "parallel.json", "jobs"))
    run("-m", "sealegs", "mystery", "--seed", "1-3", *KIND, "--judge", "--json", str(serial))
    ray = [str(EXAMPLE), "--seeds", "1-3", *KIND, "--workers", "2", "--jobs", str(jobs), "--json", str(parallel)]
    said = run(*ray)
    assert parallel.read_bytes() == serial.read_bytes()
    assert "3 mysteries" in said
    written = {file.name: file.stat().st_mtime_ns for file in jobs.iterdir()}
    assert len(written) == 4, "the list and a file for each mystery"
    parallel.unlink()
    assert run(*ray) == said
    assert {file.name: file.stat().st_mtime_ns for file in jobs.iterdir()} == written, "nothing is done twice"
    assert parallel.read_bytes() == serial.read_bytes()
