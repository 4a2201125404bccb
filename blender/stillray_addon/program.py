# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Finds the program `stillray` and what it can do, without bpy."""
import os
import re
import shutil
import subprocess
import sys
import time

OLDEST = (0, 1, 0)
VARIABLE = "STILLRAY"
_TIMEOUT_SECONDS = 20


class ProgramError(RuntimeError):
    pass


class Program:
    def __init__(self, path, version, options):
        self.path = path
        self.version = version
        self.options = options  # of `stillray denoise`

    def has(self, option):
        return option in self.options


def executable_name(platform=sys.platform):
    return "stillray.exe" if platform == "win32" else "stillray"


def candidates(preference, environment, addon_folder, which=shutil.which, platform=sys.platform):
    """(where it was named, path) in the order in which they count. A path that the user gave is the
    only one: if it is wrong, an error says so."""
    if preference.strip():
        return [("the preferences of the add-on", preference.strip())]
    if environment.get(VARIABLE, "").strip():
        return [(f"the environment variable {VARIABLE}", environment[VARIABLE].strip())]
    name = executable_name(platform)
    found = []
    on_path = which(name)
    if on_path:
        found.append(("PATH", on_path))
    for folder in (os.path.join(addon_folder, "bin"), addon_folder, os.path.dirname(addon_folder)):
        path = os.path.join(folder, name)
        if os.path.isfile(path):
            found.append(("the folder of the add-on", path))
    return found


def parse_version(text):
    match = re.search(r"\bstillray (\d+)\.(\d+)\.(\d+)", text)
    return tuple(int(g) for g in match.groups()) if match else None


def parse_options(help_text):
    return set(re.findall(r"(?<![\w-])--[a-z][\w-]*", help_text))


def no_window():
    """Arguments of Popen that keep Windows from opening a console."""
    return {"creationflags": 0x08000000} if sys.platform == "win32" else {}


def _ask(path, *arguments):
    result = subprocess.run([path, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, timeout=_TIMEOUT_SECONDS, **no_window())
    return result.stdout.decode("utf-8", "replace")


# (path, time of change) -> (Program or ProgramError, when). The panel looks at every redraw; a
# fault may pass without a change of the file, as one under a busy virus scanner.
_examined = {}
_FAULT_SECONDS = 10.0


def examine(path, where):
    """Runs the program for its version and options. Raises ProgramError."""
    path = os.path.abspath(os.path.expanduser(path))
    if os.path.isdir(path):
        path = os.path.join(path, executable_name())
    if not os.path.isfile(path):
        raise ProgramError(f"The program stillray is not at {path} (named by {where})")
    key = (path, os.path.getmtime(path))
    found, when = _examined.get(key, (None, 0.0))
    stale = isinstance(found, ProgramError) and time.monotonic() - when > _FAULT_SECONDS
    if found is None or stale:
        try:
            found = _examine(path, where)
        except ProgramError as error:
            found = error
        _examined[key] = (found, time.monotonic())
    if isinstance(found, ProgramError):
        raise found
    return found


def _examine(path, where):
    try:
        version_text = _ask(path, "--version")
        help_text = _ask(path, "denoise", "--help")
    except (OSError, subprocess.SubprocessError) as error:
        raise ProgramError(f"{path} (named by {where}) does not start: {error}") from error
    version = parse_version(version_text)
    if version is None:
        raise ProgramError(f"{path} (named by {where}) is not stillray: --version prints "
                           f"'{version_text.strip()[:80]}'")
    if version < OLDEST:
        raise ProgramError(f"{path} is stillray {'.'.join(map(str, version))}; this add-on needs "
                           f"{'.'.join(map(str, OLDEST))} or later")
    return Program(path, version, parse_options(help_text))


def find(preference, environment, addon_folder):
    """Raises ProgramError with what to do."""
    named = candidates(preference, environment, addon_folder)
    if not named:
        raise ProgramError(
            "The program stillray was not found. Set its path in Preferences > Add-ons > stillray, "
            f"or in the environment variable {VARIABLE}, or put it on the PATH")
    first_error = None
    for where, path in named:
        try:
            return examine(path, where)
        except ProgramError as error:
            first_error = first_error or error
    raise first_error
