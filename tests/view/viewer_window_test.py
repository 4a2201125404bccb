# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Drives `stillray view` with mouse and keys and looks at the screen.

    viewer_window_test.py PROGRAM           mouse and keys, on the CPU
    viewer_window_test.py PROGRAM devices   pictures of Vulkan devices
"""
import json
import os
import struct
import subprocess
import sys
import tempfile
import time

from display import Display, difference, require, until

PICTURE = (40, 60, 560, 480)  # well within the picture of a window of 960 x 600
PANEL = (660, 30, 940, 598)
# Mean difference of two pictures 0.4 s apart. At one sample per pixel the noise that the filter leaves
# differs by 0.8 to 1.2; a camera that still moves by 4 and more.
AT_REST = 2


class Viewer:
    def __init__(self, display, program, folder, *more, **environment):
        self.display = display
        self.report = os.path.join(folder, "report.json")
        self.process = subprocess.Popen(
            [program, "view", "builtin:cornell", "--size", "960x600", "--spp", "1", "--scale", "0.25",
             "--bounces", "1", "--report", self.report, *more],
            env={**display.environment, **environment}, stderr=subprocess.PIPE, cwd=folder)
        display.do("search", "--sync", "--name", "stillray")
        self.window = subprocess.run(["xdotool", "search", "--name", "stillray"], check=True,
                                     env=display.environment, capture_output=True,
                                     text=True).stdout.split()[0]
        display.show(self.window)
        display.do("mousemove", 300, 300)

    def check_alive(self):
        assert self.process.poll() is None, self.process.stderr.read().decode()


def settled(display, box):
    """The screen once the picture in the box has come to rest."""
    last = [display.screen()]

    def quiet():
        time.sleep(0.4)
        now = display.screen()
        rest = difference(last[0], now, box) < AT_REST
        last[0] = now
        return rest

    until("a picture at rest", quiet)
    return last[0]


def test_shows_a_picture(display, viewer):
    until("a bright picture", lambda: display.screen().mean(PICTURE) > 40)
    screen = settled(display, PICTURE)
    assert screen.roughness(PICTURE) < 6, "the denoised picture is smooth"
    assert 10 < screen.mean(PANEL) < 120, "the panel is dark with text"
    viewer.check_alive()


def test_orbits(display, viewer):
    before = settled(display, PICTURE)
    display.drag((200, 250), (330, 270))
    after = settled(display, PICTURE)
    assert difference(before, after, PICTURE) > 8, difference(before, after, PICTURE)
    display.key("Home")
    again = settled(display, PICTURE)
    assert difference(before, again, PICTURE) < 4, "Home brings the file's camera back"


def test_flies(display, viewer):
    before = settled(display, PICTURE)
    display.do("keydown", "w")
    time.sleep(0.6)
    display.do("keyup", "w")
    assert difference(before, settled(display, PICTURE), PICTURE) > 4
    display.key("Home")
    settled(display, PICTURE)


def test_orbits_around_what_is_clicked(display, viewer):
    before = settled(display, PICTURE)
    display.do("mousemove", 150, 200, "sleep", "0.1", "click", 1)
    time.sleep(0.5)
    mark = (140, 190, 160, 210)
    assert difference(before, display.screen(), mark) > 5, "the place is marked"
    time.sleep(2)
    rest = settled(display, PICTURE)
    assert difference(before, rest, PICTURE) < 4, "the camera stays"
    display.key("Home")
    settled(display, PICTURE)


def line_at(screen, x):
    """Whether a bright upright line stands at x."""
    rows = range(100, 460, 6)
    return sum(max(screen.row(y, x - 2, x + 3)) > 225 for y in rows) > 0.95 * len(rows)


def test_divides(display, viewer):
    display.key("Tab")
    middle = 315  # half of the picture beside a panel of 330
    until("a divider in the middle",
          lambda: line_at(display.screen(), middle))
    screen = display.screen()
    noisy = screen.roughness((60, 100, 280, 460))
    clean = screen.roughness((340, 100, 560, 460))
    assert noisy > 2 * clean, (noisy, clean)
    display.drag((middle, 250), (150, 250))
    until("the divider where it was dragged to", lambda: line_at(display.screen(), 150))
    assert not line_at(display.screen(), middle)
    display.key("Tab")
    display.key("Tab")
    until("one picture again", lambda: not line_at(display.screen(), 150))


def test_changes_the_preset(display, viewer):
    before = settled(display, PANEL)
    display.key("p")
    until("another preset in the panel",
          lambda: difference(before, display.screen(), PANEL) > 0.05)
    viewer.check_alive()


def test_saves_a_picture(display, viewer, folder):
    path = os.path.join(folder, "shown.png")
    display.key("ctrl+s")
    time.sleep(0.5)
    display.key("ctrl+a")
    display.do("type", "--delay", "60", path)
    display.key("Return")
    until("the saved picture", lambda: os.path.exists(path))
    with open(path, "rb") as file:
        head = file.read(24)
    assert head[:8] == b"\x89PNG\r\n\x1a\n"
    width, height = struct.unpack(">2I", head[16:])
    # At --scale 0.25 the picture is 158 pixels wide; the window shows it as large as this.
    assert (width, height) == (630, height) and height > 500, (width, height)


def test_asks_before_it_overwrites(display, viewer, folder):
    path = os.path.join(folder, "mine.png")
    with open(path, "w", encoding="utf-8") as file:
        file.write("not to be lost")
    display.key("ctrl+s")
    time.sleep(0.5)
    display.key("ctrl+a")
    display.do("type", "--delay", "60", path)
    display.key("Return")
    time.sleep(2)
    assert os.path.getsize(path) == len("not to be lost"), "overwritten without a question"
    display.key("Return")
    until("the picture, after the question", lambda: os.path.getsize(path) > 1000)


def test_tab_only_switches_panes(display, viewer):
    """After a click into the panel Tab moved the keyboard to a field, and digits went there."""
    settled(display, PANEL)
    display.do("mousemove", 800, 560, "sleep", "0.1", "click", 1)
    for _ in range(3):
        display.key("Tab")
    display.do("mousemove", 300, 300)
    until("one picture again", lambda: not line_at(display.screen(), 315))
    display.key("Tab")
    until("a divider in the middle", lambda: line_at(display.screen(), 315))
    display.key("Tab")
    until("two dividers", lambda: line_at(display.screen(), 210) and line_at(display.screen(), 420))
    display.key("Tab")
    until("one picture at the end", lambda: not line_at(display.screen(), 210))
    viewer.check_alive()


def test_tells_what_is_wrong(display, viewer):
    before = settled(display, PICTURE)
    display.key("ctrl+o")
    time.sleep(0.5)
    display.key("ctrl+a")
    display.do("type", "--delay", "60", "/no/such.glb")
    display.key("Return")
    time.sleep(2)  # the dialog goes, the message comes
    until("a message box", lambda: difference(before, display.screen(), PICTURE) > 3)
    viewer.check_alive()
    display.key("Return")
    until("the picture again", lambda: difference(before, display.screen(), PICTURE) < 2)


def test_resizes(display, viewer):
    display.do("windowsize", viewer.window, 700, 420)
    until("an empty screen beside the window",
          lambda: max(display.screen().row(300, 720, 940)) == 0)
    small = (40, 60, 330, 330)
    until("the picture in the small window", lambda: display.screen().mean(small) > 40)
    display.do("windowsize", viewer.window, 960, 600)
    until("the picture in the large window", lambda: display.screen().mean(PICTURE) > 40)
    viewer.check_alive()


def test_quits(display, viewer):
    display.key("ctrl+q")
    assert viewer.process.wait(timeout=30) == 0, viewer.process.stderr.read().decode()
    with open(viewer.report, encoding="utf-8") as file:
        report = json.load(file)
    print(report)
    assert report["pictures"] > 10
    # That it never stops for long; how short the gaps are on an idle machine, freeze_test.py tells.
    assert report["slowest_ms"] < 3000, report
    assert report["longest_gap_ms"] < 3000, report
    assert report["answers"] > 5, report
    # Small pictures come faster than the window shows them: then more of them fit into the wait.
    assert report["most_frames_to_answer"] <= 2 or report["slowest_answer_ms"] < 100, report


def look(display, program, folder, accept, *arguments, **environment):
    """What a window of its own shows once it is acceptable, its report, and what it prints."""
    viewer = Viewer(display, program, folder, *arguments, **environment)
    try:
        until("a bright picture", lambda: display.screen().mean(PICTURE) > 40)
        until("the picture expected", lambda: accept(display.screen()), seconds=120)
        screen = display.screen()
        viewer.check_alive()
        display.key("ctrl+q")
        assert viewer.process.wait(timeout=30) == 0
        with open(viewer.report, encoding="utf-8") as file:
            return screen, json.load(file), viewer.process.stderr.read().decode()
    finally:
        if viewer.process.poll() is None:
            viewer.process.kill()
        viewer.process.wait()


def test_runs_on_vulkan(display, program, folder):
    """Traced and filtered by a software or real device: the CPU's picture, whether it comes to the
    window through shared memory or as a copy."""
    devices = subprocess.run([program, "info", "--devices"], capture_output=True, text=True).stdout
    if "vulkan:0" not in devices or "not usable" in devices:
        print("  skipped, there is no usable device:", devices.strip())
        return
    common = ["--preset", "svgf"]
    expected, report, _ = look(display, program, folder, lambda _: settled(display, PICTURE),
                               "--device", "cpu", *common)
    assert report["shared_pictures"] == 0, report

    def close(screen):
        return max(difference(expected, screen, PICTURE, channel) for channel in range(3)) < 4

    for name, environment in (("as it is", {}), ("without memory objects", {
            "MESA_EXTENSION_OVERRIDE": "-GL_EXT_memory_object_fd"})):
        screen, report, printed = look(display, program, folder, close, "--device", "vulkan",
                                       *common, **environment)
        print(" ", name + ":", report["shared_pictures"], "of", report["pictures"],
              "pictures through shared memory")
        assert printed.startswith("rendering on vulkan:"), printed
        assert screen.roughness(PICTURE) < 6, "the denoised picture is smooth"
        assert report["shared_pictures"] == 0 or not environment, report
        if not environment and "llvmpipe" in devices and " GPU" not in devices:
            assert report["shared_pictures"] > 0, "OpenGL, in software here, is the same device"


def drive(display, program, folder):
    viewer = Viewer(display, program, folder)
    try:
        for test in (test_shows_a_picture, test_orbits, test_flies,
                     test_orbits_around_what_is_clicked, test_divides,
                     test_changes_the_preset):
            print(test.__name__, flush=True)
            test(display, viewer)
        for test in (test_saves_a_picture, test_asks_before_it_overwrites):
            print(test.__name__, flush=True)
            test(display, viewer, folder)
        for test in (test_tab_only_switches_panes, test_tells_what_is_wrong, test_resizes,
                     test_quits):
            print(test.__name__, flush=True)
            test(display, viewer)
    finally:
        if viewer.process.poll() is None:
            viewer.process.kill()
        viewer.process.wait()


def main():
    require("Xvfb", "xdotool")
    program = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder, Display() as display:
        if sys.argv[2:] == ["devices"]:
            test_runs_on_vulkan(display, program, folder)
        else:
            drive(display, program, folder)


if __name__ == "__main__":
    main()
