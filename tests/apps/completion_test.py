# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Shell completion and manual page name what --help names, and work in the shells that are here.

    completion_test.py PROGRAM
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM = sys.argv.pop(1)


def run(*arguments, **more):
    return subprocess.run(arguments, capture_output=True, text=True, check=True, **more).stdout


def options_of(help_text):
    """As the lines of --help begin: not read from the tables that the scripts are made from."""
    heads = re.findall(r"^  (-\S.*)$", help_text, re.MULTILINE)
    return {name for head in heads for name in re.findall(r"(?:^|,)(--?[\w-]+)", head.split("  ")[0])}


class CompletionTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        top = run(PROGRAM, "--help")
        names = re.findall(r"^  (\w+)  ", top.split("Subcommands:")[-1], re.MULTILINE)
        cls.options = {name: options_of(run(PROGRAM, name, "--help")) for name in names}
        cls.scripts = {shell: run(PROGRAM, "completion", shell) for shell in ("bash", "zsh", "fish")}
        cls.page = run(PROGRAM, "man")

    def test_help_was_read(self):
        self.assertLessEqual({"render", "denoise", "completion", "man"}, set(self.options))
        self.assertLessEqual({"-o", "--output", "--no-jitter", "--preset"}, self.options["render"])

    def section(self, shell, command):
        """The part of a script that is about one command."""
        text = self.scripts[shell]
        if shell == "bash":
            return re.search(rf'^    {command}:\*\)\n      options="(.*)"$', text, re.M).group(1)
        if shell == "zsh":
            return re.search(rf"^      {command}\)\n(.*?)^        ;;", text, re.M | re.S).group(1)
        return "\n".join(re.findall(rf"^.*from {command}'.*$", text, re.M))

    def test_every_option_is_completed(self):
        for command, options in self.options.items():
            bash = set(self.section("bash", command).split())
            self.assertEqual(bash, options, command)
            zsh = set(re.findall(r"^        '(?:\(.*?\)|\*)?(--?[\w-]+)", self.section("zsh", command), re.M))
            self.assertEqual(zsh, options, command)
            fish = self.section("fish", command)
            found = {"--" + name for name in re.findall(r" -l ([\w-]+)", fish)}
            found |= {"-" + name for name in re.findall(r" -s (\w)\b", fish)}
            self.assertEqual(found, options, command)

    def test_the_manual_page_names_every_command_and_option(self):
        page = self.page.replace("\\-", "-")
        parts = re.split(r"^\.SS stillray (\w+)$", page, flags=re.M)
        sections = dict(zip(parts[1::2], parts[2::2]))
        self.assertEqual(set(sections), set(self.options))
        for command, options in self.options.items():
            found = set(re.findall(r"\\fB(--?[\w-]+)\\fR", sections[command]))
            self.assertLessEqual(options, found, command)

    @unittest.skipUnless(shutil.which("man"), "man is not installed")
    def test_the_manual_page_is_valid(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "stillray.1")
            path.write_text(self.page, encoding="utf-8")
            shown = subprocess.run(
                ["man", "--warnings", "-E", "UTF-8", "-l", "-Tutf8", str(path)],
                capture_output=True, text=True, check=True, env={"LC_ALL": "C.UTF-8", "PATH": "/usr/bin:/bin",
                                                    "MANWIDTH": "100", "MANPAGER": "cat"})
        self.assertEqual(shown.stderr, "")
        self.assertIn("stillray render", shown.stdout)

    # ---- in the shells ------------------------------------------------------------------------

    def bash(self, line, breaks=" \t\n\"'><=;|&(:"):
        """What bash would offer behind `line`."""
        program = """
            eval "$1"; COMP_WORDBREAKS="$3"; COMP_LINE="$2"; COMP_POINT=${#2}
            _stillray 2>/dev/null; printf '%s\\n' "${COMPREPLY[@]}" """
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "a scene.glb").touch()
            out = run("bash", "-c", program, "bash", self.scripts["bash"], line, breaks, cwd=folder)
        return out.split("\n")[:-1] if out.strip() else []

    def test_bash(self):
        self.assertEqual(self.bash("stillray re"), ["render", "report"])
        self.assertEqual(self.bash("stillray --ver"), ["--version"])
        self.assertEqual(self.bash("stillray denoise --win"), ["--window"])
        self.assertEqual(self.bash("stillray denoise x --window "), ["auto", "past", "both"])
        self.assertEqual(self.bash("stillray denoise --window=b"), ["both"])
        self.assertEqual(self.bash("stillray render x --sampler h"), ["halton16"])
        self.assertIn("svgf", self.bash("stillray render x --preset sv"))
        self.assertEqual(self.bash("stillray render x --set sigma_l"), ["sigma_l="])
        self.assertEqual(self.bash("stillray completion z"), ["zsh"])
        self.assertEqual(self.bash("stillray help den"), ["denoise"])
        # The shell replaces what stands behind the colon, a break between its words.
        self.assertEqual(self.bash("stillray render builtin:corn"), ["cornell"])
        self.assertEqual(self.bash("stillray render a"), ["a scene.glb"])
        self.assertEqual(self.bash("stillray render x -o a"), ["a scene.glb"])
        self.assertEqual(self.bash("stillray fly --"), [])
        self.assertEqual(self.bash("stillray render builtin:corn", " \t\n"), ["builtin:cornell"])
        self.assertEqual(self.bash("stillray denoise --window=b", " \t\n"), ["--window=both"])

    @unittest.skipUnless(shutil.which("fish"), "fish is not installed")
    def test_fish(self):
        def offers(line):
            program = "source (echo $argv[1] | psub); complete -C $argv[2]"
            with tempfile.TemporaryDirectory() as home:
                environment = {"HOME": home, "PATH": "/usr/bin:/bin", "TERM": "dumb"}
                out = run("fish", "--no-config", "-c", program, self.scripts["fish"], line,
                          env=environment, cwd=home)
            return [entry.split("\t")[0] for entry in out.splitlines()]

        self.assertEqual(offers("stillray rep"), ["report"])
        self.assertEqual(offers("stillray denoise --win"), ["--window"])
        self.assertEqual(sorted(offers("stillray denoise --window ")), ["auto", "both", "past"])
        self.assertIn("builtin:cornell", offers("stillray render builtin:"))

    @unittest.skipUnless(shutil.which("zsh"), "zsh is not installed")
    def test_zsh(self):
        # Completion runs only in an interactive shell: one at a pseudo-terminal is sent Tab.
        program = """
            zmodload zsh/zpty; zpty shell "zsh -f -i"
            tell() { zpty -w shell "$1"; }
            expect() { local text=""; while zpty -r -t shell part 2>/dev/null || sleep 0.1; do
              text+="$part"; [[ "$text" == *$1* ]] && break; (( ++count > 100 )) && break; done; print -r -- "$text"; }
            tell "PS1=; unset zle_bracketed_paste; autoload -Uz compinit; compinit -u -D; source $1; print READY-1"
            expect $'READY-1\\r' >/dev/null
            zpty -w -n shell $'stillray denoise --window=bo\\t\\n'
            expect both """
        with tempfile.TemporaryDirectory() as home:
            script = pathlib.Path(home, "_stillray")
            script.write_text(self.scripts["zsh"], encoding="utf-8")
            run("zsh", "-n", str(script))
            environment = {"HOME": home, "PATH": "/usr/bin:/bin", "TERM": "dumb"}
            shown = subprocess.run(["zsh", "-f", "-c", program, "zsh", str(script)], text=True,
                                   capture_output=True, env=environment, cwd=home, timeout=60).stdout
        self.assertIn("--window=both", re.sub(r"\x1b\[[\d?]*[a-zA-Z]", "", shown))

    def test_an_unknown_shell_is_refused(self):
        refused = subprocess.run([PROGRAM, "completion", "csh"], capture_output=True, text=True)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("found 'csh', expected bash, zsh or fish", refused.stderr)


if __name__ == "__main__":
    unittest.main()
