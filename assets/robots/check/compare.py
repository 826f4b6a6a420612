"""Loads every URDF of a folder, lets it fall, and compares mass matrices and gravity torques with Pinocchio.

    pip install pin==4.1.0 example-robot-data==6.0.0
    cargo build --release -p sealegs-cli -p sealegs-leg --bins --examples
    python assets/robots/check/compare.py target/release FOLDER -o assets/robots/check/table.md

FOLDER is searched for `*.urdf`; without it, it is the one of the wheel `example-robot-data`. For each file

- `sealegs run FILE --duration 0.3` falls from a fixed base: it must end with status 0, at no step with a speed that has
  run away, and with at most 1 % of the energy in motion unexplained;
- the example `mass_matrix` prints M(q) and g(q) at three postures as they are simulated. Pinocchio's `crba` and
  `computeGeneralizedGravity` get the same postures. The error is the greatest difference of an entry over the greatest
  entry of Pinocchio's matrix (vector).

Where sealegs has mended a body's mass properties, the file's own are what no body has and the two programs simulate
different robots. Then the table has both numbers: against the file as Pinocchio reads it, and against Pinocchio with
the mended bodies in the places of those alone. A body counts as mended only where a remark of sealegs names it.
"""

import argparse
import datetime
import json
import pathlib
import re
import subprocess
import sys

import numpy as np
import pinocchio as pin

DURATION_S = 0.3
MOST_UNEXPLAINED = 0.01


def run(*command):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=900)


def fall(binary, urdf):
    """What came of a fall: (whether it held, in words)."""
    done = run(binary, "run", urdf, "--duration", DURATION_S, "--json", "-")
    if done.returncode != 0:
        return False, done.stderr.strip().splitlines()[-1] if done.stderr.strip() else f"status {done.returncode}"
    result = json.loads(done.stdout)
    unexplained = result["worst_energy_residual"]
    if result["stopped"]:
        return False, result["stopped"]
    speed = max((abs(j["speed"]) for j in result["joints"]), default=0.0)
    words = f"{unexplained:.1e}, {speed:.0f} rad/s"
    return unexplained <= MOST_UNEXPLAINED, words


def inertia(body):
    xx, xy, xz, yy, yz, zz = body["inertia_kg_m2"]
    matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return pin.Inertia(body["mass_kg"], np.array(body["com_m"]), matrix)


def difference(ours, model):
    """Greatest relative differences of M and g over the postures."""
    data = model.createData()
    ids = [model.getJointId(name) for name in ours["joints"]]
    columns = [model.joints[i].idx_v for i in ids]
    worst = [0.0, 0.0]
    for posture in ours["postures"]:
        q = pin.neutral(model)
        for value, i in zip(posture["q"], ids):
            joint = model.joints[i]
            if joint.nq == 2:
                q[joint.idx_q : joint.idx_q + 2] = np.cos(value), np.sin(value)
            else:
                q[joint.idx_q] = value
        mass = pin.crba(model, data, q)
        mass = np.triu(mass) + np.triu(mass, 1).T
        gravity = pin.computeGeneralizedGravity(model, data, q)
        theirs = mass[np.ix_(columns, columns)], gravity[columns]
        own = np.array(posture["mass_matrix"]), np.array(posture["gravity_torques"])
        for k in range(2):
            scale = np.abs(theirs[k]).max()
            gap = np.abs(own[k] - theirs[k]).max()
            worst[k] = max(worst[k], gap / scale if scale > 0 else gap)
    return worst


def compare(example, urdf):
    """(M and g against the file, mended links, M and g with the mended bodies), or a word why not."""
    done = run(example, urdf)
    if done.returncode != 0:
        return done.stderr.strip()
    ours = json.loads(done.stdout)
    try:
        model = pin.buildModelFromUrdf(str(urdf))
    except Exception as error:
        return f"Pinocchio: {str(error).splitlines()[0]}"
    model.gravity.linear = np.array([0.0, 0.0, -9.81])
    plain = difference(ours, model)
    named = [re.search(r": link '([^']*)': what the joint moves", r) for r in ours["remarks"]]
    named = {m.group(1) for m in named if m}
    for body in ours["bodies"]:
        if body["link"] in named:
            frame = model.frames[model.getFrameId(body["link"], pin.FrameType.BODY)]
            model.inertias[frame.parentJoint] = inertia(body)
    return plain, sorted(named), difference(ours, model)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binaries", type=pathlib.Path, help="the folder with `sealegs` and `examples/mass_matrix`")
    parser.add_argument("folder", type=pathlib.Path, nargs="?")
    parser.add_argument("-o", "--output", type=pathlib.Path)
    arguments = parser.parse_args()
    folder = arguments.folder
    if folder is None:
        shares = (p / "share/example-robot-data/robots" for p in pathlib.Path(pin.__file__).parents)
        folder = next((p for p in shares if p.is_dir()), None)
        if folder is None:
            sys.exit("example-robot-data is not installed beside pinocchio: name a folder")
    files = sorted(folder.rglob("*.urdf"))
    rows, counts = [], {"falls": 0, "compared": 0, "agrees": 0, "as read": 0}
    for number, urdf in enumerate(files, 1):
        name = urdf.relative_to(folder).as_posix()
        held, words = fall(arguments.binaries / "sealegs", urdf)
        counts["falls"] += held
        result = compare(arguments.binaries / "examples/mass_matrix", urdf)
        if isinstance(result, str):
            mended, plain, patched = "", result.replace(str(urdf), name), ""
        else:
            (m, g), links, (m_mended, g_mended) = result
            counts["compared"] += 1
            counts["agrees"] += max(m_mended, g_mended) <= 1e-9
            counts["as read"] += max(m, g) <= 1e-9
            plain = f"{m:.1e}, {g:.1e}"
            patched = f"{m_mended:.1e}, {g_mended:.1e}" if links else ""
            mended = f"{len(links)}" if links else ""
        rows.append(f"| {name} | {'yes' if held else 'NO'}: {words.replace(str(urdf), name)} | {plain} | {mended} | {patched} |")
        print(f"{number}/{len(files)} {rows[-1]}", file=sys.stderr, flush=True)
    version = run(arguments.binaries / "sealegs", "--version").stdout.strip()
    table = "\n".join(
        [
            "# Other people's robots",
            "",
            f"Made by `compare.py` with {version} on {datetime.date.today()}.",
            "",
            f"{counts['falls']} of {len(files)} fall for {DURATION_S} s; of the {counts['compared']} that both load, "
            f"{counts['as read']} agree with Pinocchio {pin.__version__} within 1e-9 as the file stands and "
            f"{counts['agrees']} with the mended bodies in both.",
            "",
            "| file | falls: energy unexplained, fastest joint at the end | M, g as read | mended bodies | M, g with them |",
            "|---|---|---|---|---|",
            *rows,
            "",
        ]
    )
    if arguments.output:
        arguments.output.write_text(table)
    else:
        print(table)


if __name__ == "__main__":
    main()
