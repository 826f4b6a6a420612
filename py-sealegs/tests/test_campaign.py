"""Campaigns of files and of tables in memory."""

from __future__ import annotations

import numpy as np
import pandas
import polars
import pytest
import sealegs
import tomllib
from conftest import built


@pytest.mark.parametrize("frame", [dict, pandas.DataFrame, polars.DataFrame], ids=["dict", "pandas", "polars"])
def test_tables_in_memory_make_the_campaign_of_the_files(read, description, tables, frame):
    framed = {role: {name: frame(t) for name, t in runs.items()} for role, runs in tables.items()}
    campaign = built(description, framed)
    assert campaign.runs == read.runs
    assert campaign.noise_std == read.noise_std
    for run in read.runs:
        for name, values in read.columns(run).items():
            assert np.array_equal(campaign.columns(run)[name], values), (run, name)


def test_a_comparison_in_memory_is_that_of_the_files_to_the_last_bit(read, description, tables):
    of_files = sealegs.compare(read, progress=False).to_dict()
    in_memory = sealegs.compare(built(description, tables), progress=False).to_dict()
    for record in (of_files, in_memory):
        del record["provenance"]
    assert in_memory == of_files


def test_structured_arrays_integers_and_strides_are_taken(description, tables):
    run, columns = next(iter(tables["fit"].items()))
    structured = np.rec.fromarrays(list(columns.values()), names=list(columns))
    campaign = built(description, {"fit": {run: structured}, "holdout": {}})
    assert np.array_equal(campaign.columns(run)["current_a"], columns["current_a"])
    every_other = {name: values[::2] for name, values in columns.items()}
    whole = {**every_other, "current_a": np.arange(len(every_other["time_s"]))}
    campaign = built(description, {"fit": {run: whole}, "holdout": {}}, sample_rate_hz=None)
    assert campaign.columns(run)["current_a"][-1] == len(every_other["time_s"]) - 1
    assert np.array_equal(campaign.columns(run)["force_1_n"], columns["force_1_n"][::2])


def test_bad_input_is_named_by_run_row_and_column(description, tables):
    def message(change, **changes) -> str:
        columns = {name: values.copy() for name, values in tables["fit"]["fit-chirp.csv"].items()}
        change(columns)
        with pytest.raises(sealegs.InputError) as raised:
            built(description, {"fit": {"chirp": columns}, "holdout": {}}, **changes)
        return str(raised.value)

    assert "chirp, row 8, column 'force_1_n': 'NaN' is not finite" in message(
        lambda c: c["force_1_n"].__setitem__(7, np.nan)
    )
    assert "chirp, row 4, column 'time_s': time goes back" in message(lambda c: c["time_s"].__setitem__(3, -1.0))
    assert "no input column" in message(lambda c: c.pop("current_a"))
    assert "unknown bench 'rigid'" in message(lambda c: None, bench="rigid")
    assert "noise_std.force_1_n" in message(lambda c: None, noise_std={"force_1_n": 0.0})
    with pytest.raises(TypeError, match="column 'force_1_n' has shape"):
        built(description, {"fit": {"a": {"force_1_n": np.zeros((3, 2))}}, "holdout": {}})


def test_the_numbers_of_a_rig_reach_its_model():
    time_s = np.arange(0, 2, 2e-3)
    masses_kg = {"light": 2.0, "heavy": 20.0}
    runs = {
        name: sealegs.simulate_bench(
            "rigid-linear",
            bench="free",
            rig={"mass_kg": mass_kg},
            time_s=time_s,
            motor_force_n=100 * np.cos(9 * time_s),
        ).frame("polars")
        for name, mass_kg in masses_kg.items()
    }

    def error(**rigs) -> float:
        noise_std = {"position_m": 1e-4, "speed_m_s": 1e-3}
        campaign = sealegs.Campaign.from_frames(
            "slide", bench="free", model="rigid-linear", fit=runs, noise_std=noise_std, **rigs
        )
        return sealegs.compare(campaign, as_is=True, progress=False).given.fit_error

    # The model's own runs, but for the start, which is a parabola through the first rows.
    own = error(rigs={name: {"mass_kg": mass_kg} for name, mass_kg in masses_kg.items()})
    wrong = error(rig={"mass_kg": 2.0})
    assert wrong > 100 * own, (own, wrong)
    with pytest.raises(sealegs.InputError, match="'length_m' is for the bench pendulum, not for 'free'"):
        error(rig={"length_m": 1.0})
    with pytest.raises(sealegs.InputError, match="rigs names a run 'lihgt'; there is light, heavy"):
        error(rigs={"lihgt": {"mass_kg": 2.0}})


def test_a_window_cuts_runs_into_pieces():
    time_s = np.arange(0, 2, 2e-3)
    table = {"time_s": time_s, "motor_force_n": np.cos(9 * time_s), "position_m": 1e-3 * np.sin(9 * time_s)}

    def cut(bench: str) -> sealegs.Campaign:
        return sealegs.Campaign.from_frames(
            "slide", bench=bench, model="rigid-linear", fit={"a": table}, noise_std={"position_m": 1e-6}, window_s=0.5
        )

    assert list(cut("free").runs) == [f"a from {start:.1f} s" for start in (0, 0.5, 1, 1.5)]
    with pytest.raises(sealegs.InputError, match="'free' and 'robot'"):
        cut("locked")


def test_a_table_that_names_no_columns_is_refused(description):
    with pytest.raises(TypeError, match="holds no named columns"):
        built(description, {"fit": {"a": [1, 2, 3]}, "holdout": {}})


def test_a_file_with_an_error_is_an_input_error(tmp_path):
    (tmp_path / "campaign.toml").write_text('bench = "lockt"\nactuator = "thor-linear"\n')
    with pytest.raises(sealegs.InputError, match="campaign.toml, line 1.*did you mean 'locked'"):
        sealegs.Campaign.read(tmp_path)


def test_frames_come_back(read):
    run = next(iter(read.runs))
    assert read.frame(run, "pandas").columns[0] == "time_s"
    assert read.frame(run, "polars").shape == (len(read.columns(run)["time_s"]), len(read.columns(run)))
    with pytest.raises(ValueError, match="'dask' is no library of frames"):
        read.frame(run, "dask")


def two_units() -> tuple[dict, dict[str, str]]:
    """Runs of two benches whose springs differ, by role and name, and the unit of each."""
    time_s = np.arange(0, 1.5, 2e-3)
    noise = np.random.default_rng(7)
    roles: dict = {"fit": {}, "holdout": {}}
    units = {}
    for unit, stiffness_n_m in (("left", 655e3), ("right", 600e3)):
        actuator = sealegs.actuator("thor-linear")
        actuator.parameters["stiffness"]["value"] = stiffness_n_m
        for role, phase in (("fit", 0.0), ("holdout", 1.0)):
            current_a = 2 * np.sin(6.3 * time_s * (0.5 + 8 * time_s) + phase)
            run = sealegs.simulate_bench(actuator, time_s=time_s, current_a=current_a)
            forces = {name: run[name] + 2.0 * noise.standard_normal(len(time_s)) for name in ("force_1_n", "force_2_n")}
            angle_rad = run["motor_angle_rad"] + 4.4e-4 * noise.standard_normal(len(time_s))
            name = f"{unit}-{role}.csv"
            roles[role][name] = {"time_s": time_s, "current_a": current_a, **forces, "motor_angle_rad": angle_rad}
            units[name] = unit
    return roles, units


def test_each_of_several_units_has_values_and_a_model_file_of_its_own(tmp_path):
    roles, units = two_units()
    noise_std = {"force_1_n": 2.0, "force_2_n": 2.0, "motor_angle_rad": 4.4e-4}
    given = dict(bench="locked", model="thor-linear", noise_std=noise_std, **roles)
    campaign = sealegs.Campaign.from_frames("two legs", units=units, **given)
    better = sealegs.add("coulomb-friction", campaign, progress=False)
    assert [each.unit for each in better.units.each] == ["left", "right"]
    assert "stiffness" in [differing.parameter for differing in better.units.differing]
    stiffness = {}
    for unit in ("left", "right"):
        file = tomllib.loads(better.model_file(tmp_path, unit))
        assert file["provenance"]["unit"] == unit
        stiffness[unit] = file["parameters"]["stiffness"]["value"]
    # The prior of the stiffness is 3 %, and the load cells' gains are free.
    assert stiffness["right"] / stiffness["left"] == pytest.approx(600 / 655, rel=0.02)
    with pytest.raises(sealegs.InputError, match="has the units 'left', 'right'"):
        better.model_file(tmp_path)
    with pytest.raises(sealegs.InputError, match="has no unit 'middle'; it has 'left', 'right'"):
        better.model_file(tmp_path, "middle")
    with pytest.raises(sealegs.InputError, match="units names a run 'lfet'"):
        sealegs.Campaign.from_frames("two legs", units={"lfet": "left"}, **given)

    # The same of files.
    lines = ['bench = "locked"', 'actuator = "thor-linear"', "[noise_std]"]
    lines += [f"{channel} = {std}" for channel, std in noise_std.items()]
    for role, runs in roles.items():
        for name, columns in runs.items():
            table = np.column_stack(list(columns.values()))
            np.savetxt(tmp_path / name, table, "%.17g", ",", header=",".join(columns), comments="")
            lines += ["[[run]]", f'file = "{name}"', f'role = "{role}"', f'unit = "{units[name]}"']
    (tmp_path / "campaign.toml").write_text("\n".join(lines))
    of_files = sealegs.compare(sealegs.Campaign.read(tmp_path), progress=False)
    assert of_files.units == sealegs.compare(campaign, progress=False).units
