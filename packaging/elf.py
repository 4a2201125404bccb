# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Programs and libraries of Linux: what they need, and how they are made to find it beside them.

    elf.py check LIMIT FILE...     fails if a file needs symbols of a glibc newer than LIMIT ("2.35")
"""

import pathlib
import re
import shutil
import struct
import subprocess
import sys

# Parts of glibc, which come with the machine.
GLIBC = {"libc.so.6", "libm.so.6", "libdl.so.2", "libpthread.so.0", "librt.so.1", "libresolv.so.2",
         "ld-linux-x86-64.so.2"}  # fmt: skip
VERNEED, VERSYM, HIDDEN = 0x6FFFFFFE, 0x6FFFFFFF, 0x8000


def output_of(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def needed(path):
    """Names of the libraries that a file is linked with."""
    return re.findall(r"\(NEEDED\).*\[(.*)\]", output_of("readelf", "-dW", str(path)))


def libraries_of(path):
    """Paths of all libraries that a file needs, directly or not, without those of glibc."""
    found = dict(re.findall(r"^\s*(\S+) => (/\S+)", output_of("ldd", str(path)), re.MULTILINE))
    missing = re.findall(r"^\s*(\S+) => not found", output_of("ldd", str(path)), re.MULTILINE)
    if missing:
        raise SystemExit("error: %s needs %s, which is not here" % (path, ", ".join(missing)))
    return {name: pathlib.Path(where) for name, where in found.items() if name not in GLIBC}


def closure(names, available):
    """These libraries and those that they need, of the available ones."""
    done, wanted = [], list(names)
    while wanted:
        name = wanted.pop()
        if name in available and name not in done:
            done.append(name)
            wanted += needed(available[name])
    return done


def newest(path, family):
    """(major, minor, ...) of the newest version of symbols of a family, such as GLIBC, that the file
    needs; () if it needs none."""
    info = output_of("readelf", "-VW", str(path))
    _, _, info = info.partition("Version needs section")
    versions = re.findall(r"Name: %s_([0-9.]+)" % family, info)
    return max((tuple(map(int, version.split("."))) for version in versions), default=())


def copy_library(source, target, path="$ORIGIN", name=None, replaced=None):
    """Copies a library so that it looks for others in `path` first, whatever LD_LIBRARY_PATH says.
    name: what it is called by those that need it; replaced: new names of those that it needs."""
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source, target)
    target.chmod(0o755)
    subprocess.run(["strip", "--strip-unneeded", str(target)], check=True)
    # One change per call: patchelf 0.14 mixes up the texts of several.
    changes = [["--replace-needed", old, new]
               for old, new in (replaced or {}).items() if old in needed(target)]  # fmt: skip
    if name:
        changes.append(["--set-soname", name])
    changes.append(["--force-rpath", "--set-rpath", path])
    for change in changes:
        subprocess.run(["patchelf", *change, str(target)], check=True)


class Versions:
    """The tables of the versions that a 64-bit little-endian ELF file needs, for changes in place."""

    def __init__(self, path):
        self.path = path
        self.data = bytearray(pathlib.Path(path).read_bytes())
        if self.data[:6] != b"\x7fELF\x02\x01":
            raise ValueError("%s is no 64-bit ELF file" % path)
        (offset,) = struct.unpack_from("<Q", self.data, 0x28)
        size, count = struct.unpack_from("<HH", self.data, 0x3A)
        sections = [struct.unpack_from("<IIQQQQIIQQ", self.data, offset + i * size) for i in range(count)]
        self.need = next(s for s in sections if s[1] == VERNEED)
        self.symbols = next(s for s in sections if s[1] == VERSYM)
        self.names = sections[self.need[6]]

    def _name(self, at):
        start = self.names[4] + at
        return bytes(self.data[start : self.data.index(0, start)]).decode()

    def drop(self, version):
        """Symbols of this version are then found in any library, and the version is not asked for."""
        need = self.need[4]
        while True:
            _, count, _, first, following = struct.unpack_from("<HHIII", self.data, need)
            before, entry = None, need + first
            for _ in range(count):
                _, _, index, name, step = struct.unpack_from("<IHHII", self.data, entry)
                if self._name(name) == version:
                    self._unlink(need, before, entry, count)
                    self._free(index)
                    return
                before, entry = entry, entry + step
            if following == 0:
                raise ValueError("%s does not need %s" % (self.path, version))
            need += following

    def _unlink(self, need, before, entry, count):
        if count == 1:
            raise ValueError("%s: the only version of a library is not dropped" % self.path)
        (step,) = struct.unpack_from("<I", self.data, entry + 12)
        link = need + 8 if before is None else before + 12  # vn_aux, or vna_next of the one before
        (past,) = struct.unpack_from("<I", self.data, link)
        struct.pack_into("<I", self.data, link, past + step if step else 0)
        struct.pack_into("<H", self.data, need + 2, count - 1)

    def _free(self, index):
        start, size = self.symbols[4], self.symbols[5]
        for at in range(start, start + size, 2):
            if struct.unpack_from("<H", self.data, at)[0] & ~HIDDEN == index:
                struct.pack_into("<H", self.data, at, 1)  # VER_NDX_GLOBAL

    def write(self):
        pathlib.Path(self.path).write_bytes(self.data)


def check(limit, files):
    wanted = tuple(map(int, limit.split(".")))
    bad = [path for path in files if newest(path, "GLIBC") > wanted]
    for path in bad:
        found = ".".join(map(str, newest(path, "GLIBC")))
        print("%s needs glibc %s, expected at most %s" % (path, found, limit), file=sys.stderr)
    return not bad


if __name__ == "__main__":
    if len(sys.argv) < 4 or sys.argv[1] != "check":
        sys.exit(__doc__)
    sys.exit(0 if check(sys.argv[2], sys.argv[3:]) else 1)
