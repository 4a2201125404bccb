# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""`stillray view` without a window: the same pictures in every run, and clear errors.

    headless_test.py PROGRAM
"""
import os
import subprocess
import sys
import tempfile


def run(program, *arguments, **environment):
    return subprocess.run([program, "view", *arguments], capture_output=True, text=True, timeout=120,
                          env={**os.environ, **environment})


def files(folder):
    contents = {}
    for name in sorted(os.listdir(folder)):
        with open(os.path.join(folder, name), "rb") as file:
            contents[name] = file.read()
    return contents


def test_same_pictures(program, folder):
    seen = []
    for name, threads in (("a", "1"), ("b", "2")):
        out = os.path.join(folder, name)
        done = run(program, "builtin:lights", "--size", "80x60", "--headless-frames", "5", "--spp",
                   "1/4", "--play", "--views", "noisy,denoised", "--threads", threads, "-o", out)
        assert done.returncode == 0, done.stderr
        assert "5 frames of 80x60 at 1/4 samples per pixel" in done.stdout, done.stdout
        seen.append(files(out))
    assert list(seen[0]) == [f"view.{n:04d}.png" for n in range(1, 6)]
    assert seen[0] == seen[1]
    assert seen[0]["view.0001.png"] != seen[0]["view.0005.png"]


def test_orbit(program, folder):
    out = [os.path.join(folder, name) for name in ("still", "orbit", "near")]
    for path, orbit in zip(out, ([], ["--orbit", "90"], ["--orbit", "90", "--orbit-radius", "1"])):
        done = run(program, "builtin:cornell", "--size", "64x48", "--headless-frames", "2", "--views",
                   "normal", "--no-jitter", "--bounces", "1", *orbit, "-o", path)
        assert done.returncode == 0, done.stderr
    still, orbit, near = (files(path) for path in out)
    # An orbit begins where the camera is, unless it has another radius.
    assert still["view.0001.png"] == orbit["view.0001.png"] != near["view.0001.png"]
    assert still["view.0002.png"] == still["view.0001.png"]
    assert orbit["view.0002.png"] != orbit["view.0001.png"]


def test_settings_file(program, folder):
    path = os.path.join(folder, "a.settings")
    with open(path, "w", encoding="utf-8") as file:
        file.write("# mine\npreset=svgf\nsigma_l = 2\nrender.spp=1/2\nrender.bounces=1\n")
    out = [os.path.join(folder, name) for name in ("file", "line")]
    common = ["builtin:cornell", "--size", "64x48", "--headless-frames", "2"]
    first = run(program, *common, "--settings", path, "-o", out[0])
    assert first.returncode == 0, first.stderr
    second = run(program, *common, "--preset", "svgf", "--set", "sigma_l=2", "--spp", "1/2",
                 "--bounces", "1", "-o", out[1])
    assert second.returncode == 0, second.stderr
    assert files(out[0]) == files(out[1])


def test_errors(program, folder):
    path = os.path.join(folder, "bad.settings")
    with open(path, "w", encoding="utf-8") as file:
        file.write("preset=svgf\n\nsigma_l=much\n")
    for arguments, words in (
            (["builtin:no"], ["built-in", "'no'"]),
            (["no/such.glb"], ["no/such.glb"]),
            (["builtin:cornell", "--spp", "1/3000"], ["--spp", "1/3000"]),
            (["builtin:cornell", "--scale", "0"], ["--scale", "'0'"]),
            (["builtin:cornell", "--views", "nothing"], ["--views", "'nothing'", "denoised"]),
            (["builtin:cornell", "--views", "noisy,noisy,noisy,noisy"], ["--views", "3"]),
            (["builtin:cornell", "--size", "8x8"], ["--size", "8x8"]),
            (["builtin:cornell", "--set", "feedback=8"], ["feedback"]),
            (["builtin:cornell", "--environment", "no.hdr"], ["environment", "no.hdr"]),
            (["builtin:cornell", "--camera", "9"], ["--camera", "9"]),
            (["builtin:cornell", "--camera", "-1"], ["--camera", "-1"]),
            (["builtin:cornell", "--settings", path], ["bad.settings:3", "sigma_l", "much"]),
            (["builtin:cornell", "--settings", "no.settings"], ["no.settings"]),
            (["builtin:cornell", "--orbit", "fast"], ["--orbit", "fast"]),
            (["builtin:cornell", "--orbit", "1000"], ["--orbit", "1000", "720"]),
            (["builtin:cornell", "--orbit-radius", "2"], ["--orbit-radius", "--orbit SPEED"]),
            (["builtin:cornell", "-o", "/dev/null/x"], ["/dev/null/x"])):
        done = run(program, *arguments, "--headless-frames", "1")
        assert done.returncode == 2, (arguments, done.returncode, done.stderr)
        for word in words:
            assert word in done.stderr, (arguments, done.stderr)


def test_options_of_the_window(program, folder):
    """What only a window does is refused without one; nothing is written."""
    report = os.path.join(folder, "report.json")
    done = run(program, "builtin:cornell", "--headless-frames", "1", "--report", report)
    assert done.returncode == 2 and "--report" in done.stderr, done.stderr
    assert "--headless-frames" in done.stderr and not os.path.exists(report), done.stderr
    done = run(program, "builtin:cornell", "--headless-frames", "0", "-o", folder)
    assert done.returncode == 2, done.stderr
    assert "--headless-frames: found '0', expected 1 to" in done.stderr, done.stderr
    done = run(program, "builtin:cornell", "--still-history", "some", "--headless-frames", "1")
    assert done.returncode == 2 and "--still-history" in done.stderr, done.stderr
    done = run(program, "builtin:cornell", "--moving-filter", "eaw", "--headless-frames", "1")
    assert done.returncode == 2 and "'eaw', expected psvgf or same" in done.stderr, done.stderr


def test_scale_of_colours(program, folder):
    done = run(program, "builtin:lights", "--size", "64x48", "--headless-frames", "3", "--play",
               "--views", "motion", "--device", "cpu")
    assert done.returncode == 0, done.stderr
    assert "motion: colours from 0 to " in done.stdout and "pixels" in done.stdout, done.stdout


def test_devices(program, folder):
    """The same picture but for rounding, and which device it was."""
    common = ["builtin:cornell", "--size", "64x48", "--headless-frames", "3", "--spp", "1"]
    out = [os.path.join(folder, device) for device in ("cpu", "vulkan")]
    done = run(program, *common, "--device", "cpu", "-o", out[0])
    assert done.returncode == 0 and done.stderr.startswith("rendering on the CPU, "), done.stderr
    done = run(program, *common, "--device", "gpu", "-o", out[0])
    assert done.returncode == 2 and "--device: device is 'gpu'" in done.stderr, done.stderr
    done = run(program, *common, "--trace-device", "gpu", "-o", out[0])
    assert done.returncode == 2 and "--trace-device: device is 'gpu'" in done.stderr, done.stderr
    done = run(program, *common, "--device", "auto", VK_DRIVER_FILES="/nonexistent")
    assert done.returncode == 0 and "; no Vulkan driver\n" in done.stderr, done.stderr
    done = run(program, *common, "--device", "vulkan", "-o", out[1])
    if done.returncode != 0:
        assert done.stderr.startswith("stillray: error: --device: "), done.stderr
        print("  without a device:", done.stderr.strip())
        return
    assert done.stderr.startswith("rendering on vulkan:"), done.stderr
    assert list(files(out[0])) == list(files(out[1]))
    beside = [os.path.join(folder, name) for name in ("ahead", "in_turn")]
    for path, threads in zip(beside, ("2", "1")):
        done = run(program, *common, "--device", "vulkan", "--trace-device", "cpu", "--threads",
                   threads, "--play", "-o", path)
        assert done.returncode == 0 and done.stderr.startswith("denoising on vulkan:"), done.stderr
        assert "\ntracing on the CPU, " in done.stderr, done.stderr
    assert files(beside[0]) == files(beside[1])


def test_no_display(program, folder):
    done = run(program, "builtin:cornell", DISPLAY="", WAYLAND_DISPLAY="")
    assert done.returncode == 2, done.stderr
    assert "--headless-frames" in done.stderr, done.stderr


def main():
    program = os.path.abspath(sys.argv[1])
    for test in (test_same_pictures, test_orbit, test_settings_file, test_errors,
                 test_options_of_the_window, test_scale_of_colours, test_devices, test_no_display):
        print(test.__name__, flush=True)
        with tempfile.TemporaryDirectory() as folder:
            test(program, folder)


if __name__ == "__main__":
    main()
