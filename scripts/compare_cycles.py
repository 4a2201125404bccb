#!/usr/bin/env python3
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Times the path tracer beside Blender Cycles on the CPU: same file, size, samples, bounces, threads.

    scripts/compare_cycles.py [--scene FILE.glb] [--size 1280x720] [--bounces 1] [--threads N]

Without --scene, both render a Cornell box that this script writes as glTF: the geometry, materials,
lamp and camera of builtin:cornell's first frame, with a floor texture of its own.

Cycles: Blender renders the picture with few and with many samples; what each further sample takes is
the slope between the two, so that building the BVH, synchronising and starting count for nothing.
stillray: one whole frame with one path per
pixel, its guides (depth, normals, motion, albedos, ids) and their writing included; building the
scene is not. Both are run in turn, --repeats times, and each one's least time counts.

Needs Debian's package `blender` (3.4), whose glTF importer needs python3-numpy.
"""
import argparse
import base64
import json
import math
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

ROOT = pathlib.Path(__file__).resolve().parent.parent
FEW, MANY = 2, 18  # samples of the two renderings by Cycles


# ---- the Cornell box as glTF -------------------------------------------------------------------

HALF, HEIGHT, DEPTH = 0.2764, 0.5488, 0.5592
LAMP = (92.0, 70.0, 33.8)
MATERIALS = {  # base colour, roughness
    "white": ((0.725, 0.71, 0.68), 1.0), "red": ((0.63, 0.065, 0.05), 1.0),
    "green": ((0.14, 0.45, 0.091), 1.0), "floor": ((1.0, 1.0, 1.0), 0.55),
    "box": ((0.62, 0.64, 0.70), 0.45), "lamp": ((0.0, 0.0, 0.0), 1.0)}


def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(sum(x * x for x in a))
    return tuple(x / length for x in a)


def quad(corner, u, v):
    """Counter-clockwise seen from the side that cross(u, v) points to."""
    points = [corner, add(corner, u), add(add(corner, u), v), add(corner, v)]
    return [(p, unit(cross(u, v)), uv) for p, uv in zip(points, [(0, 0), (1, 0), (1, 1), (0, 1)])]


def box(size, angle, at):
    """Five sides of a box that stands at `at`, turned about the vertical axis."""
    c, s = math.cos(angle), math.sin(angle)
    x = (size[0] * c, 0.0, -size[0] * s)
    z = (size[2] * s, 0.0, size[2] * c)
    y = (0.0, size[1], 0.0)
    minus = lambda a: tuple(-q for q in a)
    low = add(at, tuple(-0.5 * (a + b) for a, b in zip(x, z)))
    high = add(low, add(x, z))
    return [quad(low, y, x), quad(low, z, y), quad(high, y, minus(x)), quad(high, minus(z), y),
            quad(add(low, y), z, x)]


def objects():
    """(name, material, quads)"""
    x, y, z = (2 * HALF, 0, 0), (0, HEIGHT, 0), (0, 0, DEPTH)
    corner = (-HALF, 0.0, -DEPTH)
    return [
        ("floor", "floor", [quad(corner, z, x)]), ("ceiling", "white", [quad(add(corner, y), x, z)]),
        ("back", "white", [quad(corner, x, y)]), ("left", "red", [quad(corner, y, z)]),
        ("right", "green", [quad(add(corner, x), z, y)]),
        ("tall", "white", box((0.165, 0.330, 0.165), 0.3, (-0.0905, 0.0, -0.3512))),
        ("short", "box", box((0.150, 0.165, 0.150), -0.29, (0.155, 0.0, -0.40))),
        ("lamp", "lamp",
         [quad((-0.065, HEIGHT - 0.0005, -0.332), (0.130, 0, 0), (0, 0, 0.105))])]


def planks(size):
    """A PNG of ten planks in two browns with darker joints."""
    rows = bytearray()
    for py in range(size):
        rows.append(0)
        plank = py * 10 // size
        joint = py * 10 % size < 40
        for px in range(size):
            grain = (px * 7 + plank * 131 + (py & 3) * 5) % 29
            light = (96 if joint else 170 + 30 * (plank % 3)) + grain
            rows += bytes((min(light, 255), light * 5 // 6, light * 2 // 3))

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))
    header = struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) +
            chunk(b"IDAT", zlib.compress(bytes(rows), 6)) + chunk(b"IEND", b""))


def camera_matrix(position, target):
    back = unit(tuple(p - t for p, t in zip(position, target)))
    right = unit(cross((0.0, 1.0, 0.0), back))
    up = cross(back, right)
    return [*right, 0, *up, 0, *back, 0, *position, 1]


def write_cornell(path):
    data = bytearray()
    gltf = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [],
            "meshes": [], "materials": [], "accessors": [], "bufferViews": [], "buffers": [],
            "images": [{"bufferView": 0, "mimeType": "image/png"}], "textures": [{"source": 0}],
            "samplers": [], "extensionsUsed": ["KHR_materials_emissive_strength"]}
    del gltf["samplers"]

    def view(content):
        data.extend(b"\0" * (-len(data) % 4))
        gltf["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(data), "byteLength": len(content)})
        data.extend(content)
        return len(gltf["bufferViews"]) - 1

    def accessor(content, kind, component, count, bounds=None):
        entry = {"bufferView": view(content), "componentType": component, "count": count,
                 "type": kind}
        if bounds:
            entry["min"], entry["max"] = bounds
        gltf["accessors"].append(entry)
        return len(gltf["accessors"]) - 1

    view(planks(1024))
    names = list(MATERIALS)
    for name, (colour, roughness) in MATERIALS.items():
        pbr = {"baseColorFactor": [*colour, 1], "metallicFactor": 0, "roughnessFactor": roughness}
        material = {"name": name, "pbrMetallicRoughness": pbr, "doubleSided": name != "lamp"}
        if name == "floor":
            pbr["baseColorTexture"] = {"index": 0}
        if name == "lamp":
            strength = max(LAMP)
            material["emissiveFactor"] = [c / strength for c in LAMP]
            material["extensions"] = {
                "KHR_materials_emissive_strength": {"emissiveStrength": strength}}
        gltf["materials"].append(material)
    for name, material, quads in objects():
        vertices = [v for q in quads for v in q]
        points = [v[0] for v in vertices]
        corners = [4 * i + k for i in range(len(quads)) for k in (0, 1, 2, 0, 2, 3)]
        flat = lambda k, n: struct.pack(f"<{n * len(vertices)}f", *[c for v in vertices for c in v[k]])
        attributes = {
            "POSITION": accessor(flat(0, 3), "VEC3", 5126, len(vertices),
                                 ([min(p[k] for p in points) for k in range(3)],
                                  [max(p[k] for p in points) for k in range(3)])),
            "NORMAL": accessor(flat(1, 3), "VEC3", 5126, len(vertices)),
            "TEXCOORD_0": accessor(flat(2, 2), "VEC2", 5126, len(vertices))}
        indices = accessor(struct.pack(f"<{len(corners)}H", *corners), "SCALAR", 5123, len(corners))
        gltf["meshes"].append({"name": name, "primitives": [
            {"attributes": attributes, "indices": indices, "material": names.index(material)}]})
        gltf["nodes"].append({"name": name, "mesh": len(gltf["meshes"]) - 1})
    target, angle = (0.0, 0.215, -0.28), -0.09
    eye = add(target, (0.70 * math.sin(angle), 0.09, 0.70 * math.cos(angle)))
    gltf["cameras"] = [{"type": "perspective",
                        "perspective": {"yfov": 0.72, "aspectRatio": 16 / 9, "znear": 0.01}}]
    gltf["nodes"].append({"name": "camera", "camera": 0, "matrix": camera_matrix(eye, target)})
    gltf["scenes"][0]["nodes"] = list(range(len(gltf["nodes"])))
    gltf["buffers"] = [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," +
                        base64.b64encode(bytes(data)).decode()}]
    path.write_text(json.dumps(gltf))


# ---- Cycles ------------------------------------------------------------------------------------

# Runs inside of Blender. Emissions are set from the file by name: the importer caps or moves them
# in some versions.
BLENDER = r"""
import json, sys, time
import addon_utils, bpy, numpy
numpy.bool = bool  # the importer of Blender 3.4 asks for this name, which NumPy 1.24 dropped
job = json.loads(sys.argv[sys.argv.index("--") + 1])
bpy.ops.wm.read_factory_settings(use_empty=True)
for name in ("cycles", "io_scene_gltf2"):
    addon_utils.enable(name)
bpy.ops.import_scene.gltf(filepath=job["scene"])
scene = bpy.context.scene
scene.camera = next(o for o in scene.objects if o.type == "CAMERA")
for material in bpy.data.materials:
    if material.name in job["emission"]:
        for node in material.node_tree.nodes:
            if node.type == "BSDF_PRINCIPLED":
                colour = job["emission"][material.name]
                strength = max(colour)
                node.inputs["Emission"].default_value = [c / strength for c in colour] + [1]
                node.inputs["Emission Strength"].default_value = strength
world = bpy.data.worlds.new("dark") if scene.world is None else scene.world
scene.world = world
world.use_nodes = True
for node in world.node_tree.nodes:
    if node.type == "BACKGROUND":
        node.inputs["Color"].default_value = [0, 0, 0, 1]
r, c = scene.render, scene.cycles
r.engine = "CYCLES"
r.resolution_x, r.resolution_y, r.resolution_percentage = job["width"], job["height"], 100
r.threads_mode, r.threads = "FIXED", job["threads"]
r.use_persistent_data = False  # with it, Blender 3.4 overlooks a new number of samples
r.use_compositing = r.use_sequencer = r.use_motion_blur = False
r.filepath = job["picture"]
r.image_settings.file_format = "OPEN_EXR"
r.image_settings.color_depth = "32"
scene.frame_set(scene.frame_start)
# The field of view is the vertical one in glTF.
scene.camera.data.sensor_fit = "VERTICAL"
scene.camera.data.angle_y = job["yfov"]
c.device = "CPU"
c.use_adaptive_sampling = c.use_denoising = False
c.use_auto_tile = False
c.max_bounces = c.diffuse_bounces = c.glossy_bounces = job["bounces"]
c.transmission_bounces = c.transparent_max_bounces = max(job["bounces"], job["free"])
c.volume_bounces = 0
c.sample_clamp_direct = c.sample_clamp_indirect = 0
c.blur_glossy = 0
c.light_sampling_threshold = 0
c.caustics_reflective = c.caustics_refractive = True
c.pixel_filter_type = "BOX"
def seconds(samples):
    c.samples = samples
    start = time.perf_counter()
    bpy.ops.render.render()
    return time.perf_counter() - start
times = [(seconds(job["few"]), seconds(job["many"])) for i in range(job["repeats"])]
bpy.data.images["Render Result"].save_render(job["picture"])
print("TIMES " + json.dumps(times), flush=True)
"""


def gltf_json(path):
    content = path.read_bytes()
    if content[:4] == b"glTF":
        length = struct.unpack("<I", content[12:16])[0]
        return json.loads(content[20:20 + length])
    return json.loads(content)


def emissions(gltf):
    """Radiance by name of material, where it is the same all over."""
    out = {}
    for material in gltf.get("materials", []):
        factor = material.get("emissiveFactor", [0, 0, 0])
        strength = material.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get(
            "emissiveStrength", 1.0)
        if max(factor) > 0 and "emissiveTexture" not in material:
            out[material.get("name", "")] = [c * strength for c in factor]
    return out


def time_cycles(arguments, blender, scene, folder):
    """Milliseconds for each further sample, and for a whole picture of FEW samples."""
    gltf = gltf_json(scene)
    width, height = arguments.size
    job = {"scene": str(scene), "width": width, "height": height, "threads": arguments.threads,
           "bounces": arguments.bounces, "free": 24, "few": FEW, "many": MANY, "repeats": 1,
           "emission": emissions(gltf), "yfov": gltf["cameras"][0]["perspective"]["yfov"],
           "picture": str(folder / "cycles.exr")}
    script = folder / "inside_blender.py"
    script.write_text(BLENDER)
    result = subprocess.run([blender, "-b", "--factory-startup", "-P", script, "--",
                             json.dumps(job)], capture_output=True, text=True,
                            # Blender asks the first python3 on the path where modules lie.
                            env={**os.environ, "PATH": "/usr/bin:/bin"})
    found = re.search(r"^TIMES (.*)$", result.stdout, re.M)
    if not found:
        sys.exit("compare_cycles.py: Blender rendered nothing; its last lines:\n" +
                 "\n".join((result.stdout + result.stderr).splitlines()[-12:]))
    few, many = json.loads(found.group(1))[0]
    return (many - few) / (MANY - FEW) * 1e3, few * 1e3


# ---- stillray ----------------------------------------------------------------------------------

def time_stillray(arguments, scene, folder):
    """Milliseconds of the fastest frame, and the log of the benchmark."""
    log = folder / "bench.json"
    subprocess.run([arguments.stillray, "bench", "--scene", scene, "--size",
                    "{}x{}".format(*arguments.size), "--bounces", str(arguments.bounces),
                    "--threads", str(arguments.threads), "--preset", "none", "--repeats", "9",
                    "--json", log], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    tracing = json.loads(log.read_text())["sizes"][0]["tracing"]
    return tracing["frame_min_ms"], tracing


def parse_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", type=pathlib.Path, help="a .glb or .gltf file")
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--bounces", type=int, default=1)
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--stillray", default=str(ROOT / "build/apps/stillray/stillray"))
    parser.add_argument("--blender", default="blender")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the scene and the pictures")
    parser.add_argument("--json", type=pathlib.Path, help="write the figures there too")
    arguments = parser.parse_args()
    size = re.fullmatch(r"(\d+)x(\d+)", arguments.size)
    if not size:
        parser.error(f"--size is {arguments.size}, expected WIDTHxHEIGHT")
    arguments.size = tuple(int(part) for part in size.groups())
    if arguments.scene and not arguments.scene.is_file():
        parser.error(f"--scene: no such file: {arguments.scene}")
    return arguments


def compare(arguments, blender, folder):
    scene = arguments.scene
    if scene is None:
        scene = folder / "cornell.gltf"
        write_cornell(scene)
    cycles, ours = [], []
    for i in range(arguments.repeats):
        ours.append(time_stillray(arguments, scene, folder))
        cycles.append(time_cycles(arguments, blender, scene, folder))
        print(f"{i + 1} of {arguments.repeats}: Cycles {cycles[-1][0]:.1f} ms, "
              f"stillray {ours[-1][0]:.1f} ms", file=sys.stderr, flush=True)
    per_sample = min(c[0] for c in cycles)
    frame, tracing = min(ours, key=lambda o: o[0])
    width, height = arguments.size
    version = subprocess.run([blender, "--version"], capture_output=True,
                             text=True).stdout.splitlines()[0]
    print(f"{scene.name}, {width}x{height}, 1 path per pixel, {arguments.bounces} bounces, "
          f"{arguments.threads} threads; least of {arguments.repeats} runs in turn\n")
    print("| | ms | million paths per second |\n|---|---|---|")
    rate = lambda ms: width * height / ms / 1e3
    print(f"| {version}, Cycles CPU, each further sample | {per_sample:.1f} "
          f"| {rate(per_sample):.2f} |")
    print(f"| stillray, whole frame with guides | {frame:.1f} | {rate(frame):.2f} |")
    print(f"| ratio | {per_sample / frame:.2f} | |")
    if arguments.json:
        arguments.json.write_text(json.dumps(
            {"scene": scene.name, "width": width, "height": height,
             "bounces": arguments.bounces, "threads": arguments.threads, "blender": version,
             "cycles_ms_per_sample": per_sample, "stillray_frame_ms": frame,
             "ratio": per_sample / frame, "stillray": tracing}, indent=1) + "\n")


def main():
    arguments = parse_arguments()
    blender = shutil.which(arguments.blender)
    if blender is None:
        sys.exit(f"compare_cycles.py: nothing was compared: there is no program "
                 f"'{arguments.blender}' (Debian: apt-get install --no-install-recommends blender "
                 "python3-numpy)")
    if arguments.keep:
        arguments.keep.mkdir(parents=True, exist_ok=True)
        return compare(arguments, blender, arguments.keep)
    with tempfile.TemporaryDirectory() as folder:
        return compare(arguments, blender, pathlib.Path(folder))


if __name__ == "__main__":
    main()
