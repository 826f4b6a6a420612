"""The notebook: it runs, it is short, and it finds what is hidden."""

from __future__ import annotations

from pathlib import Path

import nbformat
from nbclient import NotebookClient

EXAMPLES = Path(__file__).parents[1] / "examples"

#: Lines of code that the notebook may have.
MOST_LINES = 20


def test_the_notebook_goes_through_the_loop(hidden):
    notebook = nbformat.read(EXAMPLES / "loop.ipynb", as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert sum(len(cell.source.splitlines()) for cell in code) <= MOST_LINES
    assert not any(cell.outputs for cell in code), "the notebook is kept without outputs"
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(EXAMPLES)}}).execute()
    shown = [data for cell in code for output in cell.outputs for data in (output.get("data") or {}).items()]
    assert any(kind == "text/html" and hidden[0] in str(text) for kind, text in shown)
    assert any(kind == "image/png" for kind, _ in shown)
