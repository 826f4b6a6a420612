"""Comparison, diagnosis and addition as objects."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import sealegs


def test_the_verdict_names_what_is_hidden_with_the_attributes_of_its_json(verdict, hidden):
    assert verdict.verdict == "missing-effect"
    assert sorted(verdict.effects) == sorted(hidden)
    assert verdict.after.holdout_error < 0.5 * verdict.base.holdout_error
    assert json.loads(verdict.to_json()) == verdict.to_dict()
    assert verdict.ranking[0].effects and verdict.base.parameters[0].name
    assert hidden[0] in repr(verdict) and hidden[0] in verdict.to_text()
    assert "ranking" in dir(verdict)
    with pytest.raises(AttributeError, match="no 'rankings'; there is campaign"):
        _ = verdict.rankings


def test_the_json_is_what_its_published_schema_says(verdict):
    file = Path(__file__).parents[2] / "docs" / "schema" / "diagnose.json"
    schema = json.loads(file.read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(verdict.to_dict(), schema, cls=jsonschema.Draft202012Validator)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({**verdict.to_dict(), "verdict": "perhaps"}, schema)


def test_a_notebook_shows_the_report(verdict, hidden):
    page = verdict._repr_html_()
    assert page.startswith("<iframe srcdoc=") and hidden[0] in page
    assert "<script" not in page and page.count("<iframe") == 1


def test_the_figure_shows_measured_before_and_after(verdict):
    figure = verdict.figure()
    rows = figure.axes
    assert len(rows) >= 4
    left = {line.get_label() for line in rows[0].get_lines()}
    assert left == {"measured", "before", "after"}
    curves = {run.name: run for run in verdict.curves()}
    holdout = next(run for name, run in curves.items() if "(holdout)" in name)
    curve = holdout.channels["force_1_n"]
    before, after = (np.std(curve.measured - model) for model in (curve.before, curve.after))
    assert after < before and curve.unit == "N" and curve.measured.shape == holdout.time_s.shape
    with pytest.raises(KeyError, match="no channel nonsense"):
        verdict.figure(channels=["nonsense"])


def test_results_are_saved_by_their_ending(verdict, tmp_path):
    for name, beginning in [("v.html", b"<!"), ("v.json", b"{"), ("v.txt", b"bench-knee"), ("v.rrd", b"RRF")]:
        verdict.save(tmp_path / name)
        assert (tmp_path / name).read_bytes().startswith(beginning), name
    with pytest.raises(sealegs.InputError, match="the ending must be"):
        verdict.save(tmp_path / "v.pdf")


def test_an_added_effect_makes_a_model_that_fits_as_a_dictionary_and_as_a_file(read, verdict, tmp_path):
    better = sealegs.add(verdict.effects, read, progress=False)
    assert better.after.holdout_error < 0.5 * better.base.holdout_error
    assert {effect.id for effect in better.model.effect} == set(verdict.effects)
    file = tmp_path / "better.toml"
    file.write_text(better.model_file(tmp_path))
    of_dictionary = sealegs.compare(read, better.model, as_is=True, progress=False)
    of_file = sealegs.compare(read, file, as_is=True, progress=False)
    assert of_dictionary.given.holdout_error == of_file.given.holdout_error
    assert of_file.given.holdout_error == pytest.approx(better.after.holdout_error, rel=0.1)


def test_a_verdict_has_the_better_model_without_another_fit(read, verdict):
    better = verdict.better()
    assert better.after.holdout_error == verdict.after.holdout_error
    again = sealegs.compare(read, better.model, as_is=True, progress=False)
    assert again.given.holdout_error == pytest.approx(verdict.after.holdout_error, rel=0.1)


def test_what_cannot_be_added_is_said(read):
    with pytest.raises(sealegs.InputError, match="did you mean 'coulomb-friction'.*it can have"):
        sealegs.add("coulomb-frictoin", read, progress=False)
    with pytest.raises(sealegs.InputError, match="the model.*invalid type: integer `3`"):
        sealegs.compare(read, {"motor": 3}, progress=False)


def test_the_next_experiment_is_a_table(verdict):
    plan = verdict.plan()
    assert plan is None or plan.startswith("time_s,")
