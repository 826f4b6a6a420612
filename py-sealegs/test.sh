#!/usr/bin/env bash
# Builds the wheel and runs its tests in a fresh virtual environment: py-sealegs/test.sh [PYTEST ARGUMENTS].
# Needs Rust, a C linker and Python 3.11 or later with venv; Python's packages come by pip.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
wheel=$("$here/wheel.sh")
venv=$(dirname "$wheel")/venv
cd "$here"
"$venv/bin/pip" install --quiet "$wheel[test]"
echo "the wheel: $wheel"
"$venv/bin/python" -m pytest "$@"
