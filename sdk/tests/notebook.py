"""Executes a notebook, and looks whether all of it was executed and its runs were made."""

import os
import re
import sys

import nbformat
from nbclient import NotebookClient

path = sys.argv[1]
notebook = nbformat.read(path, as_version=4)
nbformat.validate(notebook)
cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
assert cells, "it has no code"
for cell in cells:
    # What is committed would be believed by readers, and nobody compares it.
    assert not cell.outputs and cell.execution_count is None, f"outputs are not committed: {cell.source}"
    assert not {"raises-exception", "skip-execution"}.intersection(cell.metadata.get("tags", ())), f"a cell may fail: {cell.source}"
client = NotebookClient(notebook, timeout=200, kernel_name="python3", allow_errors=False, resources={"metadata": {"path": os.path.dirname(path)}})
client.execute()
assert [cell.execution_count for cell in cells] == list(range(1, len(cells) + 1)), "not every cell was executed"
said = "".join(output.get("text", "") for cell in cells for output in cell.outputs)
driven = re.search(r"(\d+) runs driven by MyAv", said)
assert driven and int(driven[1]) > 80, said
assert "av: my_av instead of" in said, said
print(f"notebook: {len(cells)} cells, {driven[0]}")
