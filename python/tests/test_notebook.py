"""The notebook runs from the first cell to the last."""

import ctypes.util
import os
import sys

import pytest
from files import ROOT

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")
for module in ("ipykernel", "matplotlib", "pyvista", "trimesh"):
    pytest.importorskip(module)
if sys.platform == "linux" and not os.environ.get("DISPLAY") and not ctypes.util.find_library("EGL"):
    pytest.skip("PyVista draws through EGL, as of libegl1 and libgl1-mesa-dri", allow_module_level=True)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_the_notebook_runs():
    folder = ROOT / "python" / "examples"
    notebook = nbformat.read(folder / "trimtess.ipynb", as_version=4)
    client = nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(folder)}})
    client.execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert not [output for output in outputs if output.output_type == "error"]
    assert sum("image/png" in output.get("data", {}) for output in outputs) >= 2, "pictures"
