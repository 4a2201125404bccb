# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Names of frames and folders, without bpy.

`path` is os.path by default; tests give ntpath or posixpath, so that both systems' rules are tested
on either.
"""
import os
import re

# Characters that `stillray` reads as marks of a pattern.
_MARKS = re.compile(r"[#%*?\[\]]")

# A probe number that no path of a user has beside the frame number: both differ in all digits.
_PROBES = (1111111, 2222222)


class FrameNames:
    """File names of one sequence: prefix, number of at least `digits` digits, suffix."""

    def __init__(self, folder, prefix, digits, suffix):
        self.folder = folder
        self.prefix = prefix
        self.digits = digits
        self.suffix = suffix

    @classmethod
    def probe(cls, path_of_frame, path=os.path):
        """The names that path_of_frame(number) gives, whatever way Blender puts them together."""
        first, second = (path_of_frame(n) for n in _PROBES)
        folder, first = path.split(first)
        second = path.split(second)[1]
        begin = next((i for i, (a, b) in enumerate(zip(first, second)) if a != b), None)
        if begin is None:
            raise ValueError(f"'{first}' has no frame number")
        prefix, suffix = first[:begin], first[begin + len(str(_PROBES[0])):]
        digits = len(path.split(path_of_frame(1))[1]) - len(prefix) - len(suffix)
        return cls(folder, prefix, max(digits, 1), suffix)

    def name(self, frame):
        sign = "-" if frame < 0 else ""
        return f"{self.prefix}{sign}{abs(frame):0{self.digits}d}{self.suffix}"

    def file(self, frame, path=os.path):
        return path.join(self.folder, self.name(frame))

    def number(self, name):
        """The frame number of a file name, or None."""
        if not (name.startswith(self.prefix) and name.endswith(self.suffix)):
            return None
        middle = name[len(self.prefix):len(name) - len(self.suffix)]
        if not re.fullmatch(r"-?\d+", middle, re.ASCII):
            return None
        frame = int(middle)
        return frame if self.name(frame) == name else None

    def present(self, first, last, listdir=os.listdir):
        """Sorted numbers of the files in the folder, first <= number <= last."""
        try:
            names = listdir(self.folder)
        except OSError:
            return []
        numbers = (self.number(name) for name in names)
        return sorted(n for n in numbers if n is not None and first <= n <= last)

    @property
    def is_plain(self):
        """False if the program would read characters of the name as marks of a pattern."""
        return not _MARKS.search(self.prefix + self.suffix)

    @property
    def pattern(self):
        return f"{self.prefix}{'#' * self.digits}{self.suffix}"

    def inputs(self, frames):
        """Arguments that name these frames for a program that runs in the folder. `./` keeps a name
        that begins with a dash from being an option."""
        if self.is_plain and len(frames) > 1:
            return ["./" + self.pattern]
        return ["./" + self.name(n) for n in frames]

    def moved(self, folder):
        return FrameNames(folder, self.prefix, self.digits, self.suffix)


def result_folder(frames_folder, name, path=os.path):
    """The folder of the denoised frames: a name beside the noisy ones, or an absolute path."""
    name = name.strip()
    if not name:
        raise ValueError("The folder of the denoised frames has no name")
    if path.isabs(name) or path.splitdrive(name)[0]:
        return path.normpath(name)
    folder = path.normpath(path.join(frames_folder, name))
    if folder == path.normpath(frames_folder):
        raise ValueError(f"The denoised frames would replace the noisy ones in {folder}")
    return folder


def relative_argument(folder, start, path=os.path):
    """A folder as an argument of a program that runs in `start`, with slashes and one at its end:
    `stillray` then takes it as a folder whatever its name ends in."""
    try:
        text = path.relpath(folder, start)
    except ValueError:  # another drive
        text = folder
    text = text.replace(path.sep, "/").rstrip("/") + "/"
    absolute = text.startswith("/") or (path.splitdrive(text)[0] != "")
    return text if absolute or text.startswith("../") else "./" + text


def ranges(numbers):
    """[1, 2, 3, 5] as "1-3, 5"."""
    parts = []
    for n in sorted(numbers):
        if parts and parts[-1][1] == n - 1:
            parts[-1][1] = n
        else:
            parts.append([n, n])
    return ", ".join(str(a) if a == b else f"{a}-{b}" for a, b in parts)


def contiguous_around(numbers, frame, radius):
    """The run of numbers without a gap that holds frame, at most radius to either side."""
    have = set(numbers)
    first = last = frame
    while first - 1 in have and first > frame - radius:
        first -= 1
    while last + 1 in have and last < frame + radius:
        last += 1
    return list(range(first, last + 1)) if frame in have else []


def default_output(blend_path, scene_name, several_scenes, path=os.path):
    """Blender's output path for a scene that still has the default one."""
    stem = path.splitext(path.basename(blend_path))[0] or "untitled"
    if several_scenes:
        stem += " " + scene_name
    stem = re.sub(r'[#%*?<>:"/\\|\x00-\x1f]', "_", stem)
    return f"//render/{stem}.####"


def is_default_output(text, temporary_folders=()):
    """True for Blender's own default, and for the bare folder of temporary files."""
    plain = text.replace("\\", "/").rstrip("/").lower()
    known = {"", "/tmp", "/tmp/", "//tmp", "c:/tmp"}
    known.update(f.replace("\\", "/").rstrip("/").lower() for f in temporary_folders)
    return plain in known
