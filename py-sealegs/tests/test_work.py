"""Long work: progress, other threads, Ctrl-C; the command; the stubs."""

from __future__ import annotations

import ast
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import sealegs
import tomllib
from conftest import CAMPAIGNS
from sealegs import _core


def test_progress_is_told_with_growing_counts(read):
    told = []
    sealegs.diagnose(read, progress=lambda what, simulations: told.append((what, simulations)))
    words = [what for what, _ in told if what]
    counts = [simulations for _, simulations in told]
    assert words[0].startswith("refitting") and any("fitting" in w and "sets" in w for w in words)
    assert counts == sorted(counts) and counts[-1] > 100


def test_a_search_that_ends_at_once_leaves_a_verdict_that_says_so(read):
    verdict = sealegs.diagnose(read, at_most=0, progress=False)
    assert verdict.effects == [] and "ended before it was done" in verdict.sentence
    with pytest.raises(sealegs.InputError, match="at_most"):
        sealegs.diagnose(read, at_most=-1.0, progress=False)


def test_other_threads_run_meanwhile(read):
    done, ticks = threading.Event(), []

    def tick():
        while not done.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.005)

    ticker = threading.Thread(target=tick)
    ticker.start()
    began = time.monotonic()
    sealegs.diagnose(read, progress=False)
    took = time.monotonic() - began
    done.set()
    ticker.join()
    longest = max(b - a for a, b in zip(ticks, ticks[1:]))
    # With the lock held for the whole of it there would be one pause as long as the work.
    assert longest < 0.5 * took, (longest, took)


def test_what_progress_raises_stops_the_work(read):
    def raising(what, simulations):
        raise ZeroDivisionError("from progress")

    began = time.monotonic()
    with pytest.raises(ZeroDivisionError, match="from progress"):
        sealegs.diagnose(sealegs.Campaign.read(CAMPAIGNS / "leg-drop"), progress=raising)
    assert time.monotonic() - began < 20


def test_ctrl_c_stops_a_diagnosis():
    code = (
        "import sealegs, sys\n"
        f"campaign = sealegs.Campaign.read({str(CAMPAIGNS / 'leg-drop')!r})\n"
        "print('begun', flush=True)\n"
        "try:\n"
        "    sealegs.diagnose(campaign, progress=False)\n"
        "except KeyboardInterrupt:\n"
        "    sys.exit(42)\n"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "begun\n"
        time.sleep(3)
        assert process.poll() is None, "the diagnosis was done before it could be stopped"
        interrupted = time.monotonic()
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=30) == 42
        assert time.monotonic() - interrupted < 10


def program(*arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    command = Path(sys.executable).with_name("sealegs")
    return subprocess.run([str(command), *arguments], capture_output=True, text=True, cwd=cwd, check=False)


def test_the_command_is_the_program():
    assert program("--version").stdout.split()[:2] == ["sealegs", sealegs.__version__]
    assert "thor-drop" in program("list").stdout
    bad = program("compare", "nowhere")
    assert bad.returncode == 2 and bad.stderr.startswith("sealegs: nowhere") and bad.stderr.count("\n") == 1
    assert program("compair").returncode == 2


def test_the_command_simulates(tmp_path):
    done = program("run", "thor-drop", "--set", "duration_s=0.05", "--rrd", "drop.rrd", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "peak" in done.stdout or "actuator" in done.stdout
    assert (tmp_path / "drop.rrd").stat().st_size > 1000


def test_the_tour_of_the_wheel_goes_once_around_the_loop(tmp_path):
    done = program("tour", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    summary = (tmp_path / "tour" / "summary.md").read_text()
    hidden = tomllib.loads((CAMPAIGNS / "answers.toml").read_text())["leg-drop"]["effects"]
    assert f"Missing: {' + '.join(hidden)} (" in summary
    # What the tour found is a model like any other, for Python, too.
    better = sealegs.scenario(tmp_path / "tour" / "better.toml")
    assert sealegs.simulate(better, {"duration_s": 0.3}).result.peaks.ground_force_n.value > 0


def test_ctrl_c_stops_the_command_and_leaves_nothing_half_written(tmp_path):
    command = Path(sys.executable).with_name("sealegs")
    arguments = [str(command), "diagnose", str(CAMPAIGNS / "leg-drop"), "--json", "out.json"]
    with subprocess.Popen(arguments, cwd=tmp_path, stderr=subprocess.DEVNULL) as process:
        deadline = time.monotonic() + 60
        while not (tmp_path / "out.json.part").exists() and time.monotonic() < deadline:
            time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=30) == 130
    assert list(tmp_path.iterdir()) == []


def test_progress_is_a_bar_of_tqdm(read, capfd):
    sealegs.compare(read)
    # Without a comparison's own words; a diagnosis names what it tries.
    shown = capfd.readouterr().err
    assert "simulations" in shown
    sealegs.compare(read, progress=False)
    assert capfd.readouterr().err == ""


def test_the_package_is_typed_and_its_stub_is_whole():
    folder = Path(sealegs.__file__).parent
    assert (folder / "py.typed").exists()
    stub = ast.parse((folder / "_core.pyi").read_text())
    named = {node.name for node in stub.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    public = {name for name in dir(_core) if not name.startswith("_")}
    assert public <= named
    assert named - {"_Result"} <= public
    for name in sealegs.__all__:
        if name != "__version__":
            assert getattr(sealegs, name).__doc__, name


@pytest.mark.parametrize("check", [["mypy", "--strict", "-p", "sealegs"], ["mypy.stubtest", "sealegs._core"]])
def test_types_hold_and_the_stub_is_what_the_extension_takes(check, tmp_path):
    done = subprocess.run([sys.executable, "-m", *check], capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
