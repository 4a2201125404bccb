# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Runs the code of the notebook, without Jupyter, and checks the errors that it prints."""

import json
import os
import pathlib
import unittest

os.environ["MPLBACKEND"] = "Agg"
NOTEBOOK = pathlib.Path(__file__).resolve().parents[2] / "examples/python/render_and_denoise.ipynb"


class NotebookTest(unittest.TestCase):
    def test_cells_run_and_the_light_is_cleaner(self):
        cells = json.loads(NOTEBOOK.read_text())["cells"]
        sources = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
        names = {}
        for source in sources:
            if "matplotlib" in source:
                try:
                    import matplotlib  # noqa: F401
                except ImportError:
                    print("skipped: the plot (matplotlib is not installed)")
                    continue
            exec(compile(source, str(NOTEBOOK), "exec"), names)
        errors = names["errors"]
        for frame in 0, 1:  # the first and the last
            self.assertLess(2 * errors["both"][frame], errors["noisy"][frame])
        self.assertLess(errors["both"][0], errors["past"][0])  # light of the frames to come

    def test_no_results_are_kept_in_the_file(self):
        for cell in json.loads(NOTEBOOK.read_text())["cells"]:
            self.assertFalse(cell.get("outputs"))


if __name__ == "__main__":
    unittest.main()
