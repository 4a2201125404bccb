#!/usr/bin/env python3
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Checks that README.md and docs/ speak of what exists.

    docs_check.py ROOT [PROGRAM]

Links, images and their anchors lead somewhere; every page and every picture is linked; files named
in the text are there; commands, options, presets and parameters are those of PROGRAM (left out
without one) and of docs/parameters.md. Prints one line per fault; exit code 1 if there are any.
"""
import pathlib
import re
import subprocess
import sys

LINK = re.compile(r"!?\[[^\]]*\]\(([^()\s]+)\)")
SPAN = re.compile(r"`([^`]+)`")
COMMAND = re.compile(r"^(?:\$ )?(?:[\w./-]*/|\"\$)?stillray\"?\s+(\S.*)$")
OPTION = re.compile(r"(?<![\w=/.-])--?[A-Za-z][\w-]*")
SETTING = re.compile(r"([a-z][a-z0-9_]*)=([\w.,-]+)")
PATH = re.compile(r"^(?:apps|benchmarks|cmake|docs|examples|include|python|scripts|src|tests)/[\w./*-]+$")


class Page:
    """A Markdown file in parts: (line number, text) of its prose and of the lines of its code."""

    def __init__(self, path, text):
        self.path = path
        self.prose = []
        self.code = []
        self.anchors = set()
        self._split(text.splitlines())

    def _split(self, lines):
        fenced = False
        code_before = True  # an indented line is code after a blank line or another line of code
        for number, line in enumerate(lines, 1):
            if line.lstrip().startswith("```"):
                fenced = not fenced
                continue
            indented = line.startswith("    ") and code_before
            if fenced or indented:
                self._add_code(number, line.strip())
            else:
                self.prose.append((number, line))
                if line.startswith("#"):
                    self._add_anchor(line.lstrip("#").strip())
            code_before = not line.strip() or indented

    def _add_code(self, number, line):
        if self.code and self.code[-1][1].endswith("\\"):
            first, start = self.code.pop()
            number, line = first, start[:-1] + line
        self.code.append((number, line))

    def _add_anchor(self, heading):
        """The name that GitHub gives a heading."""
        kept = re.sub(r"[^\w\- ]", "", heading.lower())
        self.anchors.add(kept.replace(" ", "-"))

    def links(self):
        for number, line in self.prose:
            for target in LINK.findall(SPAN.sub("", line)):
                yield number, target

    def spans(self):
        for number, line in self.prose:
            for span in SPAN.findall(line):
                yield number, span.strip()


class Parameters:
    """Names, values and presets as docs/parameters.md lists them."""

    def __init__(self, text):
        self.values = dict(re.findall(
            r"^\| `(\w+)`(?: \([^)]*\))? \|(?:[^|]*\|){2} ([^|]+?) \|", text, re.MULTILINE))
        header = re.search(r"^\| parameter \| meaning \|.*$", text, re.MULTILINE)
        self.presets = SPAN.findall(header.group(0)) if header else []

    def fault(self, name, value):
        """What is wrong with NAME=VALUE, or None."""
        allowed = self.values[name]
        numbers = re.fullmatch(r"(\S+) to (\S+)", allowed)
        if allowed.startswith("up to"):
            good = re.fullmatch(r"\d+(,\d+)*", value) is not None
        elif numbers:
            try:
                good = float(numbers[1]) <= float(value) <= float(numbers[2])
            except ValueError:
                good = False
        else:
            good = value in allowed.split(", ")
        return None if good else f"'{name}={value}': expected {allowed}"


class Program:
    """Subcommands and their options, as --help tells them."""

    def __init__(self, path):
        self.path = path
        top = self._help()
        names = re.findall(r"^  (\w+)  ", top.split("Subcommands:")[-1], re.MULTILINE)
        self.options = {name: self._options(self._help(name)) for name in names}
        self.own = self._options(top)
        self.all = self.own.union(*self.options.values())

    def _help(self, *command):
        return subprocess.run([self.path, *command, "--help"], check=True, capture_output=True,
                              text=True).stdout

    @staticmethod
    def _options(text):
        lines = re.findall(r"^  (-\S.*)$", text, re.MULTILINE)
        return {name for line in lines for name in re.findall(r"(?:^|,)(--?[\w-]+)", line.split("  ")[0])}


class Checker:
    def __init__(self, root, program=None):
        self.root = pathlib.Path(root).resolve()
        self.faults = []
        self.program = Program(program) if program else None
        table = self.root / "docs/parameters.md"
        self.parameters = Parameters(table.read_text(encoding="utf-8") if table.exists() else "")
        paths = sorted([*self.root.glob("*.md"), *self.root.glob("docs/**/*.md"),
                        *self.root.glob("examples/**/*.md")])
        self.pages = {p: Page(p, p.read_text(encoding="utf-8")) for p in paths}
        self.linked = set()

    def add(self, path, number, what):
        self.faults.append(f"{path.relative_to(self.root)}:{number}: {what}")

    def check(self):
        for page in self.pages.values():
            self.check_links(page)
            self.check_text(page)
        self.check_scripts()
        self.check_all_linked()
        return self.faults

    def check_links(self, page):
        for number, target in page.links():
            if re.match(r"[a-z]+:", target):
                continue
            name, _, anchor = target.partition("#")
            path = (page.path.parent / name).resolve() if name else page.path
            self.linked.add(path)
            if not path.exists():
                self.add(page.path, number, f"link to '{name}', which does not exist")
            elif self.root not in [path, *path.parents]:
                self.add(page.path, number, f"link to '{name}', which is outside the project")
            elif anchor and path in self.pages and anchor not in self.pages[path].anchors:
                self.add(page.path, number, f"link to '{target}': the page has no such heading")

    def check_text(self, page):
        for number, line in page.code:
            self.check_command(page.path, number, re.split(r"\s#\s", line)[0])
        for number, span in page.spans():
            if PATH.match(span) and not any(self.root.glob(span.rstrip("/"))):
                self.add(page.path, number, f"file '{span}' does not exist")
            if self.program and span.startswith("--"):
                self.check_options(page.path, number, span, self.program.all, "any command")
            self.check_settings(page.path, number, span)
            self.check_command(page.path, number, span)

    def check_command(self, path, number, line):
        match = COMMAND.match(line)
        if not match or not self.program:
            return
        words = re.split(r"\s(?:\||&&|;)\s", match[1])[0]
        name = words.split()[0]
        if name.startswith("-"):
            self.check_options(path, number, words, self.program.own, "stillray itself")
        elif name in self.program.options:
            self.check_options(path, number, words, self.program.options[name], f"stillray {name}")
        else:
            self.add(path, number, f"'{line}': stillray has no command '{name}'")

    def check_options(self, path, number, words, known, of):
        unquoted = re.sub(r"'[^']*'|\"[^\"]*\"", "''", words)
        for option in OPTION.findall(unquoted):
            if option not in known:
                self.add(path, number, f"'{words}': {of} has no option '{option}'")
        for preset in re.findall(r"--preset[ =]([a-z]\w*)", words):
            if preset not in self.parameters.presets and not (of == "stillray bench" and
                                                              preset in ("none", "all")):
                self.add(path, number, f"'{words}': there is no preset '{preset}'")
        for name, value in re.findall(r"--set[ =](\w+)=(\S+)", words):
            if name == "name":  # the placeholder of name=value
                continue
            if name not in self.parameters.values:
                self.add(path, number, f"'{words}': there is no parameter '{name}'")
            else:
                self.check_settings(path, number, f"{name}={value}")

    def check_settings(self, path, number, span):
        """Settings by name=value alone; other names may be words of --aov or of C++."""
        if any("=" not in word for word in span.split()):
            return
        for name, value in SETTING.findall(span):
            if name in self.parameters.values:
                fault = self.parameters.fault(name, value)
                if fault:
                    self.add(path, number, fault)

    def check_scripts(self):
        for path in sorted(self.root.glob("scripts/*.sh")):
            page = Page(path, "```\n" + path.read_text(encoding="utf-8") + "\n```")
            for number, line in page.code:
                self.check_command(path, number - 1, line)

    def check_all_linked(self):
        readme = self.root / "README.md"
        own = {(self.root / target.partition("#")[0]).resolve()
               for _, target in self.pages[readme].links()} if readme in self.pages else set()
        for path in self.pages:
            if path.parent == self.root / "docs" and path not in own:
                self.add(path, 1, "README.md does not link to this page")
        for path in sorted((self.root / "docs/images").glob("*")):
            if path.resolve() not in self.linked:
                self.add(path, 1, "no page shows this picture")


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    faults = Checker(*sys.argv[1:]).check()
    for fault in faults:
        print(fault)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
