#!/usr/bin/env python3
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Every fault that docs_check.py is for, planted in a small project of its own."""
import pathlib
import tempfile
import unittest

import docs_check

PARAMETERS = """# Parameters

| parameter | meaning | unit | values | `default` | `svgf` |
|---|---|---|---|---|---|
| `alpha_min` (alpha) | Weight. |  | 0 to 1 | 0.1 | 0.2 |
| `kernel` | Kernel. |  | 3x3, 5x5 | 5x5 | 5x5 |
| `steps` | Steps. | pixels | up to 8 of 1 to 64 | 1,2,4 | 1,2,4 |
"""
README = "# Project\n\n[Parameters](docs/parameters.md)\n\n{}\n"
PROGRAM = """#!/bin/sh
case "$1" in
  render) echo 'Options:'; echo '  -o,--output TEXT REQUIRED   Folder'
          echo '  --set TEXT ...  A --parameter'; echo '  --preset TEXT  Preset' ;;
  *) echo 'Options:'; echo '  --version  Version'; echo
     echo 'Subcommands:'; echo '  render                      Renders' ;;
esac
"""


class DocsCheckTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.root = pathlib.Path(self.folder.name)
        self.write("docs/parameters.md", PARAMETERS)
        self.program = self.root / "program"
        self.program.write_text(PROGRAM, encoding="utf-8")
        self.program.chmod(0o755)

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def faults_of(self, text):
        self.write("README.md", README.format(text))
        return docs_check.Checker(self.root, str(self.program)).check()

    def assert_clean(self, text):
        self.assertEqual(self.faults_of(text), [])

    def assert_fault(self, text, expected):
        faults = self.faults_of(text)
        self.assertEqual(len(faults), 1, faults)
        self.assertIn(expected, faults[0])

    def test_links(self):
        self.assert_clean("[a](docs/parameters.md#parameters) [b](https://example.org/x) [c](#project)")
        self.assert_fault("[a](docs/missing.md)", "'docs/missing.md', which does not exist")
        self.assert_fault("![a](docs/images/missing.png)", "does not exist")
        self.assert_fault("[a](docs/parameters.md#none)", "no such heading")
        self.assert_fault("[a](../)", "outside the project")

    def test_the_line_of_a_fault_is_named(self):
        self.assert_fault("\n\n[a](missing.md)", "README.md:7:")

    def test_links_in_code_are_not_links(self):
        self.assert_clean("`[a](missing.md)`\n\n    [a](missing.md)\n\n```\n[a](missing.md)\n```")

    def test_pages_and_pictures_that_nothing_links(self):
        self.write("docs/lost.md", "# Lost\n")
        self.assert_fault("", "docs/lost.md:1: README.md does not link")
        self.assert_clean("[lost](docs/lost.md)")
        self.write("docs/images/lost.png", "")
        self.assert_fault("[lost](docs/lost.md)", "docs/images/lost.png:1: no page shows")

    def test_commands(self):
        self.assert_clean("    stillray render a.glb -o out --set alpha_min=0.5   # --not-an-option\n")
        self.assert_fault("\n    stillray bake a.glb", "no command 'bake'")
        self.assert_fault("`stillray bake`", "no command 'bake'")
        self.assert_fault("\n    stillray render a.glb --ouput out", "no option '--ouput'")
        self.assert_fault("```\nstillray render \\\n  --ouput out\n```", "no option '--ouput'")
        self.assert_fault("\n    build/apps/stillray/stillray render -x", "no option '-x'")
        self.assert_clean("\n    stillray render 'a --b' | less --raw")
        self.assert_clean("`stillray --version`")

    def test_words_of_help_texts_are_not_options(self):
        self.assert_fault("`--parameter`", "any command has no option")

    def test_options_in_the_text(self):
        self.assert_clean("`--preset svgf`, `--output`, `cmake --install`")
        self.assert_fault("`--reset`", "no option '--reset'")

    def test_presets_and_parameters(self):
        self.assert_fault("`--preset svfg`", "no preset 'svfg'")
        self.assert_fault("`--set alpha=1`", "no parameter 'alpha'")
        self.assert_fault("`--set alpha_min=2`", "expected 0 to 1")
        self.assert_fault("`--set alpha_min=some`", "expected 0 to 1")
        self.assert_fault("`kernel=7x7 alpha_min=1`", "expected 3x3, 5x5")
        self.assert_fault("\n    stillray render a --set steps=1,x", "expected up to 8")
        self.assert_clean("`kernel=3x3 steps=16,8`, `--set name=value`, `scale=2`")

    def test_files_named_in_the_text(self):
        self.assert_clean("`docs/parameters.md`, `docs/*.md`, `docs/`")
        self.assert_fault("`src/missing.cpp`", "'src/missing.cpp' does not exist")

    def test_scripts(self):
        self.write("scripts/demo.sh", '#!/bin/sh\n"$stillray" render a.glb \\\n  --ouput b\n')
        self.assert_fault("", "scripts/demo.sh:2:")

    def test_without_a_program_the_rest_is_checked(self):
        self.write("README.md", README.format("`stillray bake` [a](missing.md) `kernel=7x7`"))
        self.assertEqual(len(docs_check.Checker(self.root).check()), 2)


if __name__ == "__main__":
    unittest.main()
