"""Diagnoses every campaign of a folder that `make.py --set validation` made, and writes how often the verdict is right.

    venv/bin/python judge.py DIR --sealegs ../../../target/release/sealegs --verdicts VERDICTS -o ../../../tests/leg-validation.md

A verdict is `right` if it names exactly what is hidden, `tied` if it says that the data cannot tell that from what it names,
`part` if it names something of it and nothing else, and `wrong` otherwise. The answers are read after the last verdict.
"""

import argparse
import datetime
import json
import pathlib
import subprocess
import sys

from campaigns import VALIDATION
from make import COLUMN, true_params
from robot import mujoco_leg

ROOT = pathlib.Path(__file__).resolve().parents[3]


def stamp():
    """The search's stamp: that of the recovery matrix, which a test holds to be the present search's."""
    with open(ROOT / "tests/recovery-matrix.jsonl", encoding="utf-8") as lines:
        return json.loads(lines.readline())["search"]


def diagnosed(sealegs, campaign, kept):
    """The JSON of a diagnosis, which stays in the folder `kept`: what is there is not made again."""
    file = kept / f"{campaign.name}.json"
    if not file.is_file():
        done = subprocess.run(
            [sealegs, "diagnose", str(campaign), "--json", str(file)], capture_output=True, text=True, check=False
        )
        if done.returncode != 0:
            sys.exit(f"{campaign}: {done.stderr.strip()}")
    return json.loads(file.read_text())


def score(verdict, hidden):
    said = set(verdict["effects"])
    if said == hidden:
        return "right"
    if hidden in [set(tie) for tie in verdict["indistinguishable"] + verdict["same_by_another_name"]]:
        return "tied"
    return "part" if said and said < hidden else "wrong"


def model_after(verdict):
    """The named set, or the base model where nothing is named."""
    return verdict["after"] or verdict["base"]


def values(verdict, hidden):
    """Truth, value and standard error (None where it is withheld) of each hidden number that the verdict has by its name."""
    fitted = {p["name"]: p for p in model_after(verdict)["parameters"]}
    found = []
    for effect, numbers in hidden.items():
        for name, truth in numbers.items():
            p = fitted.get(f"{effect}.{name}")
            if p and isinstance(truth, (int, float)):
                found.append((truth, p["value"], p.get("std")))
    return found


def base_values(verdict, name, scale):
    """Truth, value and standard error of each of the actuators' own numbers whose interval is not withheld."""
    fitted = {p["name"]: p for p in model_after(verdict)["parameters"]}
    leg = mujoco_leg(VALIDATION[name]["runs"][0][2])
    found = []
    for actuator, row in zip(leg.names, true_params(leg, scale)):
        for number, column in COLUMN.items():
            p = fitted.get(f"{actuator}/{'reflected_inertia' if number == 'inertia' else number}")
            if p and p.get("std"):
                found.append((row[column], p["value"], p["std"]))
    return found


def holds(stated):
    """How many 95 % intervals hold the truth."""
    return sum(abs(value - truth) <= 1.96 * std for truth, value, std in stated)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--sealegs", default="sealegs")
    parser.add_argument("--made", default="make.py --set validation", help="the command that made the campaigns, for the page")
    parser.add_argument("--verdicts", type=pathlib.Path, required=True, help="folder with one JSON a campaign; what is there stays")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    campaigns = sorted(p for p in arguments.folder.iterdir() if (p / "campaign.toml").is_file())
    arguments.verdicts.mkdir(parents=True, exist_ok=True)
    made_by = arguments.verdicts / "search"
    if made_by.is_file() and made_by.read_text() != stamp():
        sys.exit(f"{arguments.verdicts}: its verdicts are of another search, {made_by.read_text()}")
    made_by.write_text(stamp())
    verdicts = {}
    for path in campaigns:
        verdicts[path.name] = diagnosed(arguments.sealegs, path, arguments.verdicts)
        print(f"{path.name}: {verdicts[path.name]['verdict']}", flush=True)
    answers = json.loads((arguments.folder / "answers.json").read_text())

    rows, scores, numbers, base, work = [], [], [], [], []
    for name, verdict in verdicts.items():
        hidden = answers[name]["effects"]
        scores.append(score(verdict, set(hidden)))
        work.append(verdict["work"]["simulations"])
        own = values(verdict, hidden)
        numbers += own
        own_base = base_values(verdict, name, answers[name]["scale"])
        base += own_base
        off = [f"{value:.4g} ({truth:.4g})" for truth, value, _ in own]
        before, after = verdict["base"]["holdout_error"], model_after(verdict)["holdout_error"]
        cells = [name, " + ".join(hidden) or "nothing", " + ".join(verdict["effects"]) or verdict["verdict"]]
        cells += [scores[-1], ", ".join(off), f"{before:.2f}", f"{after:.2f}"]
        cells += [f"{holds(own_base)} of {len(own_base)}", str(work[-1])]
        rows.append("| " + " | ".join(cells) + " |")
    good = sum(s in ("right", "tied") for s in scores)
    near = sum(abs(value - truth) <= 0.1 * abs(truth) for truth, value, _ in numbers)
    stated = [(truth, value, std) for truth, value, std in numbers if std]
    page = [
        f"# Legs, {datetime.date.today()}",
        "",
        f"Search {stamp()}. Made by `assets/campaigns/make/judge.py`: {len(rows)} leg campaigns of an independent simulator",
        f"(`{arguments.made}`) through the whole diagnosis. Errors are those of held-out runs in noise",
        "units; in brackets the truth. The effects, their sizes and the motions of v01 to v18 were looked at while the search was",
        "built (other individuals, if there are, were not): these rows show what it can do. Those of v19 to v30 were chosen",
        "afterwards, and looked at here alone. What is hidden so weakly that the base model is at the noise counts as wrong, too,",
        "where it is not named.",
        "",
        f"Right or tied: {good} of {len(rows)}. Values within 10 %: {near} of {len(numbers)}. 95 % intervals that hold the",
        f"truth: {holds(stated)} of {len(stated)} of what is hidden, {holds(base)} of {len(base)} of the actuators' own numbers.",
        f"A diagnosis took {sum(work) / len(work):.0f} simulations of a run on average, {max(work)} at most.",
        "",
        "| campaign | hidden | named | verdict | values (truth) | before | after | base intervals | simulations |",
        "|---|---|---|---|---|---|---|---|---|",
        *rows,
        "",
    ]
    arguments.output.write_text("\n".join(page))


if __name__ == "__main__":
    main()
