"""The examples: they run, they are short, and they find what is hidden."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest
import sealegs
from conftest import BENCH
from nbclient import NotebookClient

EXAMPLES = Path(__file__).parents[1] / "examples"

#: Lines of code that an example may have.
MOST_LINES = 20

#: Time for a cell, s: seconds on an idle machine, minutes beside other work; a cell that hangs still ends.
LONGEST_S = 1800


def test_the_notebook_goes_through_the_loop(hidden):
    notebook = nbformat.read(EXAMPLES / "loop.ipynb", as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert sum(len(cell.source.splitlines()) for cell in code) <= MOST_LINES
    assert not any(cell.outputs for cell in code), "the notebook is kept without outputs"
    NotebookClient(notebook, timeout=LONGEST_S, resources={"metadata": {"path": str(EXAMPLES)}}).execute()
    shown = [data for cell in code for output in cell.outputs for data in (output.get("data") or {}).items()]
    assert any(kind == "text/html" and hidden[0] in str(text) for kind, text in shown)
    assert any(kind == "image/png" for kind, _ in shown)


def test_the_snippet_finds_what_is_hidden(hidden):
    snippet = EXAMPLES / "find_missing_effect.py"
    assert len(snippet.read_text().splitlines()) <= MOST_LINES
    done = subprocess.run([sys.executable, str(snippet), str(BENCH)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    missing, added = done.stdout.splitlines()
    # Each effect's values stand behind its name in brackets.
    assert missing.startswith("Missing: ") and "It takes the error" in missing
    for effect in hidden:
        assert f"{effect} (" in missing and effect in added


@pytest.mark.parametrize("file", ["README.md", "../README.md"])
def test_the_code_of_the_readmes_is_python_of_this_package(file):
    text = (EXAMPLES.parent / file).read_text()
    blocks = [part.split("```")[0] for part in text.split("```python\n")[1:]]
    assert blocks
    for block in blocks:
        compile(block, file, "exec")
        for name in set(re.findall(r"\bsealegs\.(\w+)", block)):
            assert hasattr(sealegs, name), (file, name)
