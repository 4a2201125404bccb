# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""`stillray bench` says what it measured, and scripts/roofline.py draws it.

    bench_test.py PROGRAM ROOT
"""
import json
import os
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml


def run(*command):
    return subprocess.run(command, capture_output=True, text=True, timeout=200)


def test_presets_with_changes(program, root, folder):
    path = os.path.join(folder, "changes.json")
    done = run(program, "bench", "--size", "48x32", "--preset", "eaw,eaw:signals=single:kernel=3x3",
               "--kernel", "5x5", "--threads", "1", "--repeats", "2", "--json", path)
    assert done.returncode == 0, done.stderr
    with open(path) as file:
        split, single = json.load(file)["sizes"][0]["filter"]["subjects"]
    assert single["name"] == "eaw:signals=single:kernel=3x3"
    assert single["bytes"] < split["bytes"]
    done = run(program, "bench", "--preset", "eaw:signals=all", "--size", "48x32")
    assert done.returncode != 0
    assert "--preset: parameter 'signals' is 'all', expected one of" in done.stderr, done.stderr


def test_table_and_json(program, root, folder):
    path = os.path.join(folder, "bench.json")
    done = run(program, "bench", "--size", "96x54,64x36", "--preset", "svgf,psvgf", "--repeats", "2",
               "--json", path)
    assert done.returncode == 0, done.stderr
    for size in ("96x54", "64x36"):
        assert f"builtin:cornell, {size}, 1 spp, 1 bounces" in done.stdout, done.stdout
    with open(path) as file:
        bench = json.load(file)
    assert [(s["width"], s["height"]) for s in bench["sizes"]] == [(96, 54), (64, 36)]
    for size in bench["sizes"]:
        filters = size["filter"]
        assert filters["multiply_adds_per_second_and_thread"] > 1e7
        assert filters["copy"]["min_ms"] > 0
        found = {(s["name"], s["kernel"], s["scalar"]) for s in filters["subjects"]}
        wanted = {(name, kernel, False) for name in ("svgf, one signal", "svgf", "psvgf")
                  for kernel in ("3x3", "5x5")}
        if size is bench["sizes"][0]:
            wanted |= {("svgf, one signal", kernel, True) for kernel in ("3x3", "5x5")}
        assert found == wanted, found
        for subject in filters["subjects"]:
            # What the stages take is part of the whole.
            stages = sum(stage["min_ms"] for stage in subject["stages"].values())
            assert 0 < stages <= subject["whole"]["median_ms"] * 1.05, subject
            assert subject["bytes"] > 100 * filters["pixels"]
            assert subject["signals"] == (3 if subject["name"] == "svgf" else 1)
    # A row of the table holds the figures of the file.
    subject = bench["sizes"][0]["filter"]["subjects"][0]
    row = re.search(r"^svgf, one signal 3x3 +1 +([\d.]+) +([\d.]+)", done.stdout, re.MULTILINE)
    assert row, done.stdout
    assert abs(float(row[1]) - subject["whole"]["min_ms"]) <= 0.0051
    assert abs(float(row[2]) - subject["whole"]["median_ms"]) <= 0.0051

    picture = os.path.join(folder, "roofline.svg")
    done = run(sys.executable, "-B", os.path.join(root, "scripts/roofline.py"), path, picture)
    assert done.returncode == 0, done.stderr
    space = "{http://www.w3.org/2000/svg}"
    drawn = xml.parse(picture).getroot()
    measured = [s for s in bench["sizes"][0]["filter"]["subjects"] if not s["scalar"]]
    # Every filter stands in the plot and in its legend.
    assert len(drawn.findall(space + "circle")) == len(measured)
    assert len(drawn.findall(space + "rect")) == len(measured) + 1
    done = run(sys.executable, "-B", os.path.join(root, "scripts/roofline.py"), __file__, picture)
    assert done.returncode != 0 and "expected what `stillray bench --json` wrote" in done.stderr


def test_sparse_frames(program, root, folder):
    done = run(program, "bench", "--size", "96x54", "--spp", "1/16", "--guides", "sparse", "--preset",
               "psvgf", "--kernel", "3x3", "--threads", "0", "--repeats", "2")
    assert done.returncode == 0, done.stderr
    assert re.search(r"^fill_guides +[\d.]+$", done.stdout, re.MULTILINE), done.stdout


def test_frames_per_second(program, root, folder):
    """Of a scene whose camera, objects and light move; by the CPU and, if there is one, a device."""
    devices = run(program, "info", "--devices").stdout
    usable = "vulkan:0" in devices and "not usable" not in devices
    for device in ["cpu"] + (["vulkan"] if usable else []):
        path = os.path.join(folder, f"{device}.json")
        done = run(program, "bench", "--fps", "--device", device, "--size", "64x36", "--repeats", "3",
                   "--warm-up", "1", "--json", path)
        assert done.returncode == 0, done.stderr
        assert "builtin:lights, 64x36, 1 spp" in done.stdout, done.stdout
        for name in ("raw tracing", "temporal only", "full SVGF"):
            assert re.search(rf"^{name} +[\d.]+ +[\d.]+ \.\. [\d.]+ ", done.stdout, re.MULTILINE), done.stdout
        with open(path) as file:
            size = json.load(file)["sizes"][0]
        fps = {c["name"]: c["fps"] for c in size["configurations"]}
        for rate in fps.values():
            assert 0 < rate["min"] <= rate["mean"] <= rate["max"], fps
        assert fps["raw tracing"]["mean"] > fps["temporal only"]["mean"], fps
        blocks = size["memory_blocks"]
        for name, count in blocks["sum"].items():
            parts = [blocks["cpu"][name], blocks["devices"][name]]
            known = [part for part in parts if part] or [0]
            expected = (min(known) if name.startswith("smallest") else
                        max(known) if name.startswith("largest") else sum(parts))
            assert count == expected, (name, blocks)
        for part in blocks.values():
            assert part["allocated_bytes"] <= part["block_bytes"], blocks
            assert part["smallest_allocation"] <= part["largest_allocation"], blocks
        # Frame, histories and work planes of two denoisers.
        assert blocks["cpu"]["allocations"] == blocks["cpu"]["blocks"] > (20 if device == "cpu" else 0)
        assert (blocks["devices"]["blocks"] > 0) == (device != "cpu"), blocks
        assert re.search(r"^  CPU +\d+ +\d+ ", done.stdout, re.MULTILINE), done.stdout
        assert ("  sum " in done.stdout) == (device != "cpu"), done.stdout
        memory = {part["name"]: part for part in size["memory"]}
        # What is not known is not there; a frame on the host has planes, and nobody counts allocations.
        for part in memory.values():
            assert all(value for value in part.values()), part
        assert "allocations" not in memory["frame"], memory
        planes = memory["frame"].get("images_and_buffers", 1)
        assert memory["frame"]["bytes"] > 64 * 36 * 4 * planes * 0.99, memory
        assert memory["full SVGF"]["bytes"] >= memory["temporal only"]["bytes"] > 0, memory
        if device != "cpu":
            assert memory["full SVGF"]["allocations"] > 0, memory
            path = os.path.join(folder, "stages.json")
            done = run(program, "bench", "--device", device, "--size", "64x36", "--preset", "svgf",
                       "--repeats", "2", "--json", path)
            assert done.returncode == 0, done.stderr
            with open(path) as file:
                subjects = json.load(file)["subjects"]
            assert [s["kernel"] for s in subjects] == ["3x3", "5x5"]
            assert all(s["stages"][f"atrous{level}"]["min_ms"] > 0
                       for s in subjects for level in range(1, 6)), subjects


def test_virtual_guides_of_whole_frames(program, root, folder):
    """They are traced only for filters that read them, and take 48 bytes per pixel of the frame."""
    devices = run(program, "info", "--devices").stdout
    usable = "vulkan:0" in devices and "not usable" not in devices
    reads = ["--set", "virtual_roughness=0.1", "--set", "signals=split"]
    for device in ["cpu"] + (["vulkan"] if usable else []):
        path = os.path.join(folder, "fps.json")

        def memory(*more):
            done = run(program, "bench", "--fps", "--scene", "builtin:mirrors", "--device", device,
                       "--size", "64x36", "--repeats", "1", "--warm-up", "0", "--json", path, *more)
            assert done.returncode == 0, done.stderr
            with open(path) as file:
                return {part["name"]: part["bytes"] for part in json.load(file)["sizes"][0]["memory"]}

        without, unread, read = memory(*reads, "--no-virtual-guides"), memory(), memory(*reads)
        assert unread["frame"] == without["frame"], (device, unread, without)
        assert read["frame"] >= without["frame"] + 64 * 36 * 48 * 0.99, (device, read, without)
        assert read["full SVGF"] > without["full SVGF"] > 0, (device, read, without)


def test_bad_input(program, root, folder):
    for arguments, words in (
            (["--preset", "fast"], "unknown preset 'fast'"),
            (["--kernel", "7x7"], "'kernel' is '7x7', expected 3x3 or 5x5"),
            (["--set", "sigma_l"], "--set: 'sigma_l' has no '=', expected name=value"),
            (["--set", "sigma_l=big"], "'sigma_l' is 'big'"),
            (["--size", "64x36,0x9"], "0x9"),
            (["--fps", "--size", "0x9"], "0x9"),
            (["--fps", "--device", "gpu"], "device is 'gpu'"),
            (["--device", "gpu"], "device is 'gpu'"),
            (["--scene", "missing.glb"], "missing.glb")):
        done = run(program, "bench", "--size", "64x36", "--repeats", "1", *arguments)
        assert done.returncode == 2, (arguments, done.returncode, done.stderr)
        assert words in done.stderr, (arguments, done.stderr)


def main():
    program, root = sys.argv[1], sys.argv[2]
    for name, test in list(globals().items()):
        if name.startswith("test_"):
            with tempfile.TemporaryDirectory() as folder:
                test(program, root, folder)
            print(f"{name}: passed")


if __name__ == "__main__":
    main()
