# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Writes the wheel: the Python package, libstillray and the libraries that it needs.

    make_wheel.py VERSION LIBRARY FOLDER

LIBRARY: libstillray.so.N of a release build, stripped; FOLDER gets the wheel. Uses nothing but Python,
binutils and patchelf.
"""

import base64
import hashlib
import os
import pathlib
import shutil
import sys
import tempfile
import time
import zipfile

import bundle
import elf

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Every machine of this tag has these, of GCC 12 or later.
OF_THE_MACHINE = {"libstdc++.so.6", "libgcc_s.so.1"}
GLIBC_LIMIT, GLIBCXX_LIMIT = "2.35", (3, 4, 30)
TAG = "py3-none-manylinux_2_35_x86_64"

METADATA = """\
Metadata-Version: 2.1
Name: stillray
Version: {version}
Summary: Temporally stable denoiser for path-traced animation
License: Apache-2.0
Requires-Python: >=3.8
Requires-Dist: numpy>=1.17
Classifier: License :: OSI Approved :: Apache Software License
Classifier: Operating System :: POSIX :: Linux
Classifier: Programming Language :: Python :: 3
Classifier: Topic :: Multimedia :: Graphics :: 3D Rendering
Classifier: Typing :: Typed
Description-Content-Type: text/markdown

"""
WHEEL = """\
Wheel-Version: 1.0
Generator: stillray packaging/make_wheel.py
Root-Is-Purelib: false
Tag: {tag}
"""


def unique_name(name, path):
    """A name that no other package uses: a process has one library of each name."""
    stem, _, rest = name.partition(".so")
    return "%s-%s.so%s" % (stem, hashlib.sha256(path.read_bytes()).hexdigest()[:8], rest)


def copy_libraries(library, folder):
    """libstillray into the package, all that it needs beside the package."""
    available = elf.libraries_of(library)
    wanted = [n for n in elf.closure(elf.needed(library), available) if n not in OF_THE_MACHINE]
    names = {name: unique_name(name, available[name]) for name in wanted}
    for name, new in names.items():
        elf.copy_library(available[name], folder / "stillray.libs" / new, "$ORIGIN", new, names)
    target = folder / "stillray" / library.name
    elf.copy_library(library, target, "$ORIGIN/../stillray.libs", None, names)
    files = [target, *(folder / "stillray.libs").iterdir()]
    if not elf.check(GLIBC_LIMIT, files):
        sys.exit(1)
    for path in files:
        if elf.newest(path, "GLIBCXX") > GLIBCXX_LIMIT:
            raise SystemExit("error: %s needs a newer libstdc++ than %s promises" % (path, TAG))
    return [available[name] for name in wanted]


def description():
    """docs/python.md, without its comment; its links lead nowhere outside the documents."""
    text = (ROOT / "docs/python.md").read_text(encoding="utf-8")
    return text[text.index("# The Python module") :]


def write_metadata(version, libraries, folder):
    info = folder / ("stillray-%s.dist-info" % version)
    info.mkdir()
    (info / "METADATA").write_text(METADATA.format(version=version) + description(), encoding="utf-8")
    (info / "WHEEL").write_text(WHEEL.format(tag=TAG))
    shutil.copyfile(ROOT / "LICENSE", info / "LICENSE")
    for library in libraries:
        bundle.copy_licence(library, info)


def record_line(path, folder):
    data = path.read_bytes()
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return "%s,sha256=%s,%d" % (path.relative_to(folder).as_posix(), digest, len(data))


def write_zip(folder, target):
    """In a fixed order and with one date, so that the same contents give the same file."""
    moment = time.gmtime(max(int(os.environ.get("SOURCE_DATE_EPOCH", time.time())), 315532800))
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for path in sorted(p for p in folder.rglob("*") if p.is_file()):
            entry = zipfile.ZipInfo(path.relative_to(folder).as_posix(), moment[:6])
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o100755 if ".so" in path.name else 0o100644) << 16
            archive.writestr(entry, path.read_bytes())


def main():
    version, library, output = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        shutil.copytree(ROOT / "python/stillray", folder / "stillray",
                        ignore=shutil.ignore_patterns("__pycache__"))  # fmt: skip
        for file in ("_stillray.py", "_structs.py"):
            shutil.copyfile(ROOT / "python/ctypes" / file, folder / "stillray" / file)
        write_metadata(version, copy_libraries(library, folder), folder)
        record = folder / ("stillray-%s.dist-info" % version) / "RECORD"
        lines = [record_line(p, folder) for p in sorted(folder.rglob("*")) if p.is_file()]
        lines.append(record.relative_to(folder).as_posix() + ",,")
        record.write_text("\n".join(lines) + "\n")
        target = output / ("stillray-%s-%s.whl" % (version, TAG))
        write_zip(folder, target)
    print("%s (%.1f MB)" % (target, target.stat().st_size / 1e6))


if __name__ == "__main__":
    main()
