#!/usr/bin/env python3
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""The scenes in examples/scenes are what make_scenes.py writes, and name their licence.

    example_scenes_test.py ROOT
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

FOLDER = pathlib.Path(sys.argv.pop(1)) / "examples/scenes"
SCENES = sorted(p for p in FOLDER.iterdir() if p.suffix in (".obj", ".mtl", ".gltf"))


class ExampleScenes(unittest.TestCase):
    def test_the_generator_writes_these_files(self):
        with tempfile.TemporaryDirectory() as made:
            subprocess.run([sys.executable, FOLDER / "make_scenes.py", made], check=True)
            self.assertEqual(sorted(p.name for p in pathlib.Path(made).iterdir()),
                             [p.name for p in SCENES])
            for scene in SCENES:
                self.assertEqual((pathlib.Path(made) / scene.name).read_bytes(),
                                 scene.read_bytes(), scene.name)

    def test_every_file_names_its_licence(self):
        for scene in SCENES:
            text = scene.read_text()
            if scene.suffix == ".gltf":
                self.assertIn("Apache-2.0", json.loads(text)["asset"]["copyright"], scene.name)
            else:
                self.assertEqual(text.splitlines()[:2],
                                 ["# SPDX-FileCopyrightText: the stillray developers",
                                  "# SPDX-License-Identifier: Apache-2.0"], scene.name)


if __name__ == "__main__":
    unittest.main()
