"""Campaigns of files and of tables in memory."""

from __future__ import annotations

import numpy as np
import pandas
import polars
import pytest
import sealegs
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
