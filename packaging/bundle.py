# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Puts programs and their libraries into the folder of a relocatable archive.

    bundle.py FOLDER ARC4RANDOM PROGRAM... [PLACE=LIBRARY...]

FOLDER gets libexec/ with the programs, lib/, lib/host/ (what graphics drivers use, too: see launcher.c) and the
licences of all libraries. ARC4RANDOM: the library of arc4random.c. A library that is only loaded at run
time goes to the folder PLACE.
"""

import pathlib
import shutil
import subprocess
import sys

import elf

# Folders in lib/host/, as launcher.c knows them, and the libraries that they begin with.
HOST = {"cxx": ["libstdc++.so.6", "libgcc_s.so.1"], "z": ["libz.so.1"], "x11": ["libX11.so.6"],
        "gl": ["libOpenGL.so.0"]}  # fmt: skip
GLIBC_LIMIT = "2.35"


def copy_licence(library, folder):
    """The copyright file of the Debian package that the library is from."""
    for path in (library, library.resolve(), pathlib.Path("/usr" + str(library.resolve()))):
        owner = subprocess.run(["dpkg", "-S", str(path)], capture_output=True, text=True).stdout
        name = owner.split(":")[0]
        licence = pathlib.Path("/usr/share/doc", name, "copyright")
        if name and licence.exists():
            target = folder / "licenses" / name
            target.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(licence, target / "copyright")
            return
    raise SystemExit("error: the licence of %s was not found" % library)


def copy_host_libraries(libraries, folder):
    """Returns the names of those that were copied."""
    copied = set()
    for group, begin in HOST.items():
        for name in sorted(elf.closure(begin, libraries)):
            if name not in copied:
                elf.copy_library(libraries[name], folder / "lib/host" / group / name)
                copied.add(name)
    return copied


def suit_older_glibc(folder, arc4random):
    """libstdc++ of Debian 12 is built against glibc 2.36, for one function."""
    library = folder / "lib/host/cxx/libstdc++.so.6"
    if elf.newest(library, "GLIBC") <= (2, 35):
        return
    shutil.copyfile(arc4random, library.parent / arc4random.name)
    subprocess.run(["patchelf", "--add-needed", arc4random.name, str(library)], check=True)
    versions = elf.Versions(library)
    versions.drop("GLIBC_2.36")
    versions.write()


def main():
    folder, arc4random = map(pathlib.Path, sys.argv[1:3])
    loaded = [argument.split("=", 1) for argument in sys.argv[3:] if "=" in argument]
    libraries = {}
    for program in [pathlib.Path(argument) for argument in sys.argv[3:] if "=" not in argument]:
        libraries |= elf.libraries_of(program)
        elf.copy_library(program, folder / "libexec" / program.name, "$ORIGIN/../lib")
    host = copy_host_libraries(libraries, folder)
    suit_older_glibc(folder, arc4random)
    for name, path in libraries.items():
        if name not in host:
            elf.copy_library(path, folder / "lib" / name)
        copy_licence(path, folder)
    for place, path in loaded:
        elf.copy_library(path, folder / place / pathlib.Path(path).name, "$ORIGIN")
        copy_licence(pathlib.Path(path), folder)
    files = [*folder.glob("libexec/*"), *folder.glob("**/*.so*")]
    if not elf.check(GLIBC_LIMIT, files):
        sys.exit(1)


if __name__ == "__main__":
    main()
