"""Mysteries made, diagnosed and judged on Ray: python mysteries_on_ray.py --seeds 1-64 --json judged.json

Every seed is one task. Its result is a file in the folder ``--jobs``, which the nodes of a cluster must share; what is
there and whole is not computed again. The file that is written is to the last bit that of one machine alone:

    sealegs mystery --seed 1-64 --duration 6 --judge --json judged.json

It needs ``pip install "sealegs[ray]"`` on every node. Without ``--address`` Ray runs on this machine, with
``--workers`` workers.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys

import ray


def sealegs(*arguments: str) -> str:
    """Runs the program of this package with one thread; returns what it prints. Its message is the error."""
    command = [sys.executable, "-m", "sealegs", *arguments]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, env={**os.environ, "RAYON_NUM_THREADS": "1"}
    )
    if done.returncode:
        raise RuntimeError(done.stderr.strip())
    return done.stdout


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", default="1-64", help="as of `sealegs mystery --seed`: a list, 1,4 or 1-64")
    parser.add_argument("--bench", default="locked", choices=["locked", "pendulum"])
    parser.add_argument("--level", default="easy", choices=["easy", "hard", "rough"])
    parser.add_argument("--duration", default="6", help="duration of a run, s")
    parser.add_argument("--jobs", default="judged", help="folder of the tasks' results")
    parser.add_argument("--json", default="judged.json", help="the scores")
    parser.add_argument("--address", help="of a running cluster (auto: the one that this node belongs to)")
    parser.add_argument("--workers", type=int, help="without --address: on this machine; else one for each core")
    given = parser.parse_args()
    kind = ["--bench", given.bench, "--level", given.level, "--duration", given.duration]
    mysteries = ["mystery", "--seed", given.seeds, *kind, "--judge", "--jobs", os.path.abspath(given.jobs)]
    ranges = [part.partition("-") for part in given.seeds.split(",")]
    count = sum(int(last or first) - int(first) + 1 for first, _, last in ranges)

    ray.init(address=given.address, num_cpus=None if given.address else given.workers, include_dashboard=False)
    task = ray.remote(num_cpus=1, max_retries=2)(sealegs)
    waiting = [task.remote(*mysteries, "--shard", f"{number}/{count}") for number in range(1, count + 1)]
    while waiting:
        finished, waiting = ray.wait(waiting)
        ray.get(finished)  # a task's error is raised here
        print(f"{count - len(waiting)} of {count} shards", file=sys.stderr)
    ray.shutdown()
    print(sealegs("merge", given.jobs, "--json", given.json), end="")


if __name__ == "__main__":
    main()
