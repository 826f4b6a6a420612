#!/usr/bin/env bash
# Builds the wheel and runs its tests in a fresh virtual environment: py-sealegs/test.sh [PYTEST ARGUMENTS].
# Needs Rust, a C linker and Python 3.11 or later with venv; Python's packages come by pip.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
# The workspace's own target folder and profile; a folder that is given is seen from where the caller is.
target=$(realpath -m "${CARGO_TARGET_DIR:-$here/../target}")
cd "$here"

place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
pip="$place/venv/bin/pip"
"$pip" install --quiet 'maturin>=1.9.4,<2'

CARGO_TARGET_DIR=$target "$place/venv/bin/maturin" build --release --locked --out "$place/dist"

wheel=$(ls "$place"/dist/*.whl)
"$pip" install --quiet "$wheel[test]"
mkdir -p "$target/wheels"
cp "$wheel" "$target/wheels/"
echo "the wheel: $target/wheels/$(basename "$wheel")"
"$place/venv/bin/python" -m pytest "$@"
