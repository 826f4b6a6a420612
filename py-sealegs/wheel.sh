#!/usr/bin/env bash
# Builds the wheel with maturin from a virtual environment of its own, and prints the wheel's path. Needs Rust, a C linker and
# Python 3.11 or later with venv.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
# The workspace's own target folder and profile; a folder that is given is seen from where the caller is.
target=$(realpath -m "${CARGO_TARGET_DIR:-$here/../target}")
cd "$here"

# Always in the same place: the bindings are compiled again for another interpreter.
venv=$target/wheels/venv
python3 -m venv --clear "$venv" >&2
"$venv/bin/pip" install --quiet 'maturin>=1.9.4,<2' >&2

rm -f "$target"/wheels/sealegs-*.whl
CARGO_TARGET_DIR=$target "$venv/bin/maturin" build --release --locked --interpreter "$venv/bin/python" --out "$target/wheels" >&2
ls "$target"/wheels/sealegs-*.whl
