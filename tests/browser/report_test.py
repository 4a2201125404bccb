# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Opens a report from disk in headless Chromium and uses it: real mouse, wheel, touch and keys.

    report_test.py STILLRAY

What is seen is read from screenshots. Exits with 77 if there is no browser.
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True

from png import Picture, write_png  # noqa: E402
from webdriver import Browser, missing_programs  # noqa: E402

SKIPPED = 77
WIDTH, HEIGHT = 64, 32  # so wide that the picture fills the stage
FRAMES = (1, 2, 3, 4)
# A square in the noisy picture and in no other, to see zooming and panning by.
MARK_X, MARK_Y = range(16, 24), range(12, 20)
MARK = (20 / WIDTH, 16 / HEIGHT)  # its middle, as fractions of the stage
YELLOW = (255, 255, 0)
HOSTILE = "</script><img src=x onerror=\"document.title='pwned'\"><b>room</b>"

program = None


def shade(frame):
    return 255 - 40 * (frame - 1)


def noisy(frame):
    return (shade(frame), 0, 0)


def denoised(frame):
    return (0, shade(frame), 0)


def reference(frame):
    return (0, 0, shade(frame))


def make_folder(folder):
    """Noisy red, denoised green, reference blue; darker from frame to frame."""
    for frame in FRAMES:
        write_png(folder / f"noisy.{frame:04}.png", WIDTH, HEIGHT,
                  lambda x, y: YELLOW if x in MARK_X and y in MARK_Y else noisy(frame))
        write_png(folder / f"denoised.{frame:04}.png", WIDTH, HEIGHT, lambda x, y: denoised(frame))
        write_png(folder / f"reference.{frame:04}.png", WIDTH, HEIGHT,
                  lambda x, y: reference(frame))
    log = {
        "scene": HOSTILE, "preset": "svgf", "fps": 10, "width": WIDTH, "height": HEIGHT,
        "parameters": {"sigma_l": 4.0, HOSTILE: HOSTILE},
        "frames": [{"frame": frame, "seconds": frame / 10, "denoise_ms": 10.0 + frame,
                    "render_ms": 100.0, "write_ms": 30.0, "stages_ms": {"atrous": 7.5, HOSTILE: 2.5}}
                   for frame in FRAMES],
        "memory": {"denoiser_bytes": 3 * 1024 * 1024},
    }
    (folder / "render.json").write_text(json.dumps(log), encoding="utf-8")


class ReportPage(unittest.TestCase):
    """Each test opens the page anew in the same browser."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="stillray-report-")
        cls.addClassCleanup(cls.folder.cleanup)
        folder = pathlib.Path(cls.folder.name)
        make_folder(folder)
        cls.page = folder / "the page.html"
        subprocess.run([program, "report", folder, "-o", cls.page], check=True, timeout=60,
                       stdout=subprocess.DEVNULL)
        cls.browser = Browser(1000, 900)
        cls.addClassCleanup(cls.browser.close)

    def setUp(self):
        self.browser.open("about:blank")
        self.browser.console()
        self.browser.requests()
        self.browser.open(self.page.as_uri())
        self.wait_shown("4 noisy denoised")
        self.x, self.y, self.width, self.height = self.browser.box("#stage")

    def tearDown(self):
        self.assertEqual(self.browser.console(), [], "messages in the console")
        urls = [url for url in self.browser.requests() if not url.startswith("data:image/png")]
        self.assertEqual([url for url in urls if not url.startswith("data:,")],
                         [self.page.as_uri()], "requests beyond the page itself")
        self.assertNotEqual(self.browser.script("return document.title"), "pwned")

    def wait_shown(self, state):
        self.browser.wait_for(f"document.getElementById('stage').dataset.shown === '{state}'",
                              f"the viewer shows {state}")

    def point(self, fraction_x, fraction_y):
        """A place on the stage in window pixels."""
        return (self.x + fraction_x * self.width, self.y + fraction_y * self.height)

    def look(self):
        """The stage as it is now."""
        self.browser.script("document.getElementById('stage').scrollIntoView({block: 'nearest'})")
        return Picture(self.browser.screenshot("#stage"))

    def see(self):
        """A function that tells the colour at a fraction of the stage as it is now."""
        picture = self.look()
        return lambda fx, fy: picture.at(fx * (picture.width - 1), fy * (picture.height - 1))

    def text(self, selector):
        return self.browser.script(
            "return document.querySelector(arguments[0]).textContent", selector)

    def zoom(self):
        """Screen pixels per picture pixel, in percent."""
        return float(self.browser.script(
            "return document.getElementById('zoom-level').value").rstrip(" %"))

    def split(self):
        return int(self.browser.script(
            "return document.getElementById('divider').getAttribute('aria-valuenow')"))

    def test_both_sides_show_their_view(self):
        colour = self.see()
        self.assertEqual(colour(0.1, 0.8), noisy(4))
        self.assertEqual(colour(0.45, 0.1), noisy(4))
        self.assertEqual(colour(0.55, 0.1), denoised(4))
        self.assertEqual(colour(0.9, 0.8), denoised(4))
        self.assertEqual(colour(*MARK), YELLOW)

    def test_divider_by_mouse(self):
        self.browser.pointer([self.point(0.5, 0.7), "down", self.point(0.6, 0.7),
                              self.point(0.8, 0.6), "up"])
        self.assertEqual(self.split(), 80)
        colour = self.see()
        self.assertEqual(colour(0.75, 0.8), noisy(4))
        self.assertEqual(colour(0.85, 0.8), denoised(4))
        # Let go, it stays.
        self.browser.pointer([self.point(0.3, 0.6)])
        self.assertEqual(self.split(), 80)
        # Beyond the edge it stops at the edge.
        self.browser.pointer([self.point(0.8, 0.6), "down", (self.x - 15, self.y + 20), "up"])
        self.assertEqual(self.split(), 0)
        self.assertEqual(self.see()(0.1, 0.8), denoised(4))

    def test_divider_by_touch(self):
        self.browser.pointer([self.point(0.5, 0.3), "down", self.point(0.4, 0.3),
                              self.point(0.2, 0.3), "up"], kind="touch")
        self.assertEqual(self.split(), 20)
        colour = self.see()
        self.assertEqual(colour(0.15, 0.8), noisy(4))
        self.assertEqual(colour(0.25, 0.8), denoised(4))

    def test_divider_by_keys(self):
        self.browser.script("document.getElementById('divider').focus()")
        self.browser.keys("ArrowLeft", "ArrowLeft", "ArrowLeft")
        self.assertEqual(self.split(), 47)
        self.browser.keys("ArrowRight")
        self.assertEqual(self.split(), 48)
        self.browser.keys("End")
        self.assertEqual(self.see()(0.95, 0.5), noisy(4))
        self.browser.keys("Home")
        self.assertEqual(self.see()(0.05, 0.9), denoised(4))

    def test_wheel_zooms_about_the_cursor(self):
        before = self.zoom()
        beside = (MARK[0] + 6 / WIDTH, MARK[1])
        self.assertEqual(self.see()(*beside), noisy(4))
        self.browser.wheel(*self.point(*MARK), -400)
        self.assertGreater(self.zoom(), 2 * before)
        colour = self.see()
        self.assertEqual(colour(*MARK), YELLOW, "the point under the cursor stays")
        self.assertEqual(colour(*beside), YELLOW, "the mark has grown")
        self.assertEqual(self.browser.script("return window.scrollY"), 0)
        # Squares, not a blur: no colour between the mark's and the ground's.
        picture = self.look()
        row = round(MARK[1] * picture.height)
        seen = {picture.at(x, row) for x in range(round(0.45 * picture.width))}
        self.assertEqual(seen, {YELLOW, noisy(4)})
        self.browser.click("#zoom-reset")
        self.assertEqual(self.see()(*beside), noisy(4))
        self.assertEqual(self.zoom(), before)

    def test_zoom_keeps_the_point_under_the_cursor(self):
        corner = (MARK_X.start / WIDTH, MARK_Y.start / HEIGHT)
        for _ in range(3):
            self.browser.wheel(*self.point(*corner), -250)
        colour = self.see()
        for dx, dy in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
            expected = YELLOW if dx > 0 and dy > 0 else noisy(4)
            self.assertEqual(colour(corner[0] + 0.006 * dx, corner[1] + 0.012 * dy), expected)

    def test_pinch_zooms(self):
        before = self.zoom()
        centre = self.point(*MARK)
        self.browser.pointers(
            [[(centre[0] + 20 * side, centre[1]), "down", (centre[0] + 40 * side, centre[1]),
              (centre[0] + 60 * side, centre[1]), "up"] for side in (-1, 1)], kind="touch")
        self.assertAlmostEqual(self.zoom() / before, 3, delta=0.1)
        colour = self.see()
        self.assertEqual(colour(*MARK), YELLOW)
        self.assertEqual(colour(MARK[0] + 10 / WIDTH, MARK[1]), YELLOW)

    def test_drag_pans_when_zoomed(self):
        self.browser.wheel(*self.point(*MARK), -400)
        target = (MARK[0] - 0.1, MARK[1] + 0.4)
        self.browser.pointer([self.point(*MARK), "down", self.point(MARK[0], MARK[1] + 0.1),
                              self.point(*target), "up"])
        colour = self.see()
        # The mark now measures 0.28 by 0.56 of the stage.
        self.assertEqual(colour(*target), YELLOW)
        self.assertEqual(colour(target[0] - 0.12, target[1] - 0.2), YELLOW)
        self.assertEqual(colour(target[0] + 0.16, target[1]), noisy(4))
        self.assertEqual(colour(*MARK), noisy(4))
        self.assertEqual(self.split(), 50, "the divider is not moved by panning")

    def test_views(self):
        self.browser.choose("#left-view", "reference")
        self.wait_shown("4 reference denoised")
        self.assertEqual(self.see()(0.2, 0.8), reference(4))
        self.browser.click("#swap")
        self.wait_shown("4 denoised reference")
        colour = self.see()
        self.assertEqual(colour(0.2, 0.8), denoised(4))
        self.assertEqual(colour(0.8, 0.8), reference(4))
        self.assertEqual(self.text("#left-tag"), "denoised")

    def test_error_maps(self):
        self.browser.choose("#left-view", "denoised-rel_se")
        self.wait_shown("4 denoised-rel_se denoised")
        colour = self.see()(0.2, 0.8)
        ramp = self.browser.script(
            "return JSON.parse(document.getElementById('report-data').textContent).heat.ramp")
        self.assertIn("#%02x%02x%02x" % colour, ramp[1:-1])
        self.assertIn("Relative squared error", self.text("#scales"))
        self.browser.pointer([self.point(0.2, 0.8)])
        self.assertRegex(self.text("#readout"), r"^x \d+, y \d+: denoised: Relative squared error")

    def test_pixel_under_the_cursor(self):
        self.browser.pointer([self.point(20.5 / WIDTH, 13.5 / HEIGHT)])
        self.assertEqual(self.text("#readout"), "x 20, y 13: noisy 255 255 0 \u00b7 denoised 0 135 0")

    def test_pixel_follows_the_picture_under_the_cursor(self):
        self.browser.pointer([self.point(20.5 / WIDTH, 13.5 / HEIGHT)])
        self.browser.script(
            "const select = document.getElementById('right-view'); select.value = 'reference';"
            "select.dispatchEvent(new Event('change'));")
        self.wait_shown("4 noisy reference")
        self.assertEqual(self.text("#readout"),
                         "x 20, y 13: noisy 255 255 0 \u00b7 reference 0 0 135")
        self.browser.script("document.getElementById('stage').focus()")
        self.browser.keys(",")
        self.wait_shown("3 noisy reference")
        self.assertEqual(self.text("#readout"),
                         "x 20, y 13: noisy 255 255 0 \u00b7 reference 0 0 175")

    def test_few_frames_have_no_plots(self):
        with tempfile.TemporaryDirectory(prefix="stillray-report-") as name:
            folder = pathlib.Path(name)
            for frame in (1, 2):
                for view, level in (("noisy", 40), ("denoised", 90), ("reference", 100)):
                    write_png(folder / f"{view}.{frame:04}.png", WIDTH, HEIGHT,
                              lambda x, y: (level, level, level * frame))
            page = folder / "report.html"
            subprocess.run([program, "report", folder], check=True, timeout=60,
                           stdout=subprocess.DEVNULL)
            self.browser.open(page.as_uri())
            self.wait_shown("2 noisy denoised")
            self.assertEqual(self.browser.script(
                "return document.querySelectorAll('.plot').length"), 0)
            rows = self.browser.script(
                "return [...document.querySelectorAll('#means tbody tr')].map((row) => "
                "row.cells[0].textContent)")
            self.assertEqual(rows, ["noisy", "denoised", "noisy, frame 1", "denoised, frame 1",
                                    "noisy, frame 2", "denoised, frame 2"])
            # What tearDown() looks at is the page of the other tests.
            self.browser.open("about:blank")
            self.browser.requests()
            self.browser.open(self.page.as_uri())

    def test_frame_slider(self):
        self.browser.script("document.getElementById('frame').focus()")
        self.browser.keys("ArrowLeft")
        self.wait_shown("3 noisy denoised")
        self.assertEqual(self.see()(0.2, 0.8), noisy(3))
        self.browser.keys("Home")
        self.wait_shown("1 noisy denoised")
        colour = self.see()
        self.assertEqual(colour(0.2, 0.8), noisy(1))
        self.assertEqual(colour(0.8, 0.8), denoised(1))
        self.assertEqual(self.browser.script(
            "return document.getElementById('frame-label').value"), "frame 1, 0.10 s")
        # By mouse, a click at the far end.
        x, y, width, height = self.browser.box("#frame")
        self.browser.pointer([(x + width - 4, y + height / 2), "down", "up"])
        self.wait_shown("4 noisy denoised")

    def test_play_and_pause(self):
        self.browser.script(
            "window.seen = new Set();"
            "new MutationObserver(() => seen.add(document.getElementById('stage').dataset.shown))"
            ".observe(document.getElementById('stage'), {attributes: true});")
        self.browser.click("#play")
        self.browser.wait_for("window.seen.size === 4", "all frames are played")
        self.assertEqual(self.browser.script(
            "return document.getElementById('play').getAttribute('aria-label')"), "Pause")
        self.browser.click("#play")
        frame = self.browser.script("return document.getElementById('frame').value")
        # Longer than all four frames last.
        self.browser.script("return new Promise((done) => setTimeout(done, 700))")
        self.assertEqual(frame, self.browser.script(
            "return document.getElementById('frame').value"), "paused")

    def test_keys_of_the_stage(self):
        self.browser.script("document.getElementById('stage').focus()")
        self.browser.keys(",")
        self.wait_shown("3 noisy denoised")
        self.browser.keys("s")
        self.wait_shown("3 denoised noisy")
        before = self.zoom()
        self.browser.keys("+")
        self.assertGreater(self.zoom(), before)
        self.browser.keys("0")
        self.assertEqual(self.zoom(), before)

    def test_text_of_files_is_shown_as_text(self):
        self.assertEqual(self.text("#title"), f"{HOSTILE}, svgf")
        self.assertIn(HOSTILE, self.text("#times"))
        self.assertIn(HOSTILE, self.text("#settings"))
        self.assertEqual(self.browser.script("return document.querySelectorAll('img, b').length"), 0)

    def test_tables(self):
        times = self.browser.script(
            "return [...document.querySelectorAll('#times tbody tr')]"
            ".map((row) => [...row.cells].map((cell) => cell.textContent))")
        # Names and order are those of --timings.
        self.assertEqual([row[0] for row in times], ["render", "denoise", "atrous", HOSTILE, "write"])
        self.assertEqual(times[2], ["atrous", "7.50", "7.50", "7.50", "75.0 %"])
        self.assertEqual(times[1][:4], ["denoise", "12.5", "11.0", "14.0"])
        self.assertEqual(times[4][:4], ["write", "30.0", "30.0", "30.0"])
        self.assertIn("memory, denoiser3.1 MB", self.text("#settings"))
        self.assertIn("Temporal", self.text("#means"))
        self.assertEqual(self.browser.script(
            "return getComputedStyle(document.querySelector('#times tr.part')).position"), "static")
        means = self.browser.script(
            "return [...document.querySelectorAll('#means tbody tr')].map((row) => "
            "row.cells[0].textContent)")
        self.assertEqual(means, ["noisy", "denoised"])
        details = self.browser.script(
            "return [...document.querySelectorAll('#details tr')]"
            ".map((row) => [...row.cells].map((cell) => cell.textContent))")
        self.assertEqual(details[0], [
            "Mean over frames", "Bright speckslower is better", "Dark speckslower is better",
            "Worst 1 %share of the squared error", "Darkest regionideal: 1",
            "Brightest regionideal: 1", "Light changeideal: 1"])
        self.assertEqual([row[0] for row in details[1:]], ["noisy", "denoised"])

    def test_plots_follow_the_pointer_and_lead_to_frames(self):
        self.assertEqual(self.browser.script(
            "return document.querySelectorAll('#quality-plots .plot').length"), 9)
        self.browser.script("document.querySelector('.plot svg[role=img]').scrollIntoView()")
        plot = ".plot svg[role=img]"
        x, y, width, height = self.browser.box(plot)
        self.browser.pointer([(x + 60, y + height / 2)])
        self.assertTrue(self.text(".plot .legend").endswith("frame 1"),
                        self.text(".plot .legend"))
        self.browser.pointer(["down", "up"])
        self.wait_shown("1 noisy denoised")
        self.assertGreater(self.browser.script(
            "return document.querySelector(arguments[0] + ' path.series').getTotalLength()", plot),
            50)

    def test_narrow_and_dark(self):
        try:
            self.browser.cdp("Emulation.setDeviceMetricsOverride", width=380, height=800,
                             deviceScaleFactor=2, mobile=False)
            self.browser.cdp("Emulation.setEmulatedMedia",
                             features=[{"name": "prefers-color-scheme", "value": "dark"}])
            self.browser.wait_for("document.getElementById('canvas').width > 500",
                                  "the canvas has the screen's pixels")
            self.assertEqual(self.browser.script(
                "return document.documentElement.scrollWidth"), 380, "nothing sticks out")
            colour = self.see()
            self.assertEqual(colour(0.2, 0.8), noisy(4))
            self.assertEqual(colour(0.8, 0.8), denoised(4))
            background = self.browser.script(
                "return getComputedStyle(document.body).backgroundColor")
            self.assertEqual(background, "rgb(16, 19, 23)")
        finally:
            self.browser.cdp("Emulation.setDeviceMetricsOverride", width=1000, height=900,
                             deviceScaleFactor=1, mobile=False)
            self.browser.cdp("Emulation.setEmulatedMedia",
                             features=[{"name": "prefers-color-scheme", "value": "light"}])


def main():
    global program
    if len(sys.argv) < 2:
        sys.exit("usage: report_test.py STILLRAY [unittest arguments]")
    program = os.path.abspath(sys.argv.pop(1))
    missing = missing_programs()
    if missing:
        print(f"skipped: not installed: {', '.join(missing)}")
        sys.exit(SKIPPED)
    unittest.main(verbosity=2)


if __name__ == "__main__":
    main()
