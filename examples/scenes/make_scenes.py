#!/usr/bin/env python3
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Writes the scenes in this folder: a room as Wavefront OBJ, and as glTF with animation a turntable, and a
tube and a ball that deform.

    make_scenes.py [FOLDER]
"""

import base64
import json
import math
import pathlib
import struct
import sys

# The faces of a cube, as corners that are seen counter-clockwise from outside.
CORNERS = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
FACES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 4, 6, 2), (1, 3, 7, 5), (2, 6, 7, 3), (0, 1, 5, 4)]


def turned(point, degrees):
    """About the vertical axis."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    x, y, z = point
    return (c * x + s * z, y, c * z - s * x)


LICENCE = ["# SPDX-FileCopyrightText: the stillray developers", "# SPDX-License-Identifier: Apache-2.0"]


# ---- OBJ -----------------------------------------------------------------------------------------

MATERIALS = {
    "white": "Kd 0.73 0.73 0.73",
    "red": "Kd 0.63 0.06 0.05",
    "green": "Kd 0.12 0.45 0.15",
    "lamp": "Kd 0 0 0\nKe 17 14 10",
    "gold": "Kd 0.9 0.6 0.2\nPr 0.25\nPm 1",
}
# Half a room of 4 x 3 x 4 metres, open towards the camera, and what stands in it.
QUADS = [
    ("white", [(-2, 0, -2), (-2, 0, 2), (2, 0, 2), (2, 0, -2)]),
    ("white", [(-2, 3, -2), (2, 3, -2), (2, 3, 2), (-2, 3, 2)]),
    ("white", [(-2, 0, -2), (2, 0, -2), (2, 3, -2), (-2, 3, -2)]),
    ("red", [(-2, 0, 2), (-2, 0, -2), (-2, 3, -2), (-2, 3, 2)]),
    ("green", [(2, 0, -2), (2, 0, 2), (2, 3, 2), (2, 3, -2)]),
    ("lamp", [(-0.5, 2.99, -0.5), (0.5, 2.99, -0.5), (0.5, 2.99, 0.5), (-0.5, 2.99, 0.5)]),
]
BOXES = [("white", (-0.7, 0.9, -0.8), (0.5, 0.9, 0.5), 18), ("gold", (0.8, 0.45, 0.3), (0.45, 0.45, 0.45), -20)]


def box_quads(material, centre, half, degrees):
    points = []
    for corner in CORNERS:
        place = turned([c * h for c, h in zip(corner, half)], degrees)
        points.append(tuple(p + c for p, c in zip(place, centre)))
    return [(material, [points[i] for i in face]) for face in FACES]


def write_room(folder):
    quads = QUADS + [quad for box in BOXES for quad in box_quads(*box)]
    lines = LICENCE + ["# A room with a lamp and two boxes.", "mtllib room.mtl"]
    for material, corners in quads:
        lines += ["v %.4f %.4f %.4f" % corner for corner in corners]
        lines += ["usemtl " + material, "f -4 -3 -2 -1"]
    (folder / "room.obj").write_text("\n".join(lines) + "\n")
    text = "\n\n".join("newmtl %s\n%s" % entry for entry in MATERIALS.items())
    (folder / "room.mtl").write_text("\n".join(LICENCE) + "\n" + text + "\n")


# ---- glTF ----------------------------------------------------------------------------------------


class Gltf:
    """Accessors share one buffer, which stands in the file as text."""

    def __init__(self):
        self.bytes = b""
        self.views, self.accessors = [], []

    def add(self, kind, values, indices=False):
        """Indices are also the numbers of joints."""
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}[kind]
        flat = [number for value in values for number in (value if width > 1 else (value,))]
        data = struct.pack("<%d%s" % (len(flat), "H" if indices else "f"), *flat)
        data += b"\0" * (-len(data) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)})
        self.bytes += data
        entry = {"bufferView": len(self.views) - 1, "componentType": 5123 if indices else 5126,
                 "count": len(values), "type": kind}  # fmt: skip
        if kind in ("SCALAR", "VEC3") and not indices:
            columns = list(zip(*values)) if width > 1 else [values]
            stored = [[struct.unpack("<f", struct.pack("<f", v))[0] for v in c] for c in columns]
            entry.update(min=[min(c) for c in stored], max=[max(c) for c in stored])
        self.accessors.append(entry)
        return len(self.accessors) - 1


def add_cube(gltf):
    positions, normals, indices = [], [], []
    for face in FACES:
        corners = [CORNERS[i] for i in face]
        normal = [sum(c[axis] for c in corners) / 4.0 for axis in range(3)]
        first = len(positions)
        positions += corners
        normals += [normal] * 4
        indices += [first + i for i in (0, 1, 2, 0, 2, 3)]
    return {"POSITION": gltf.add("VEC3", positions), "NORMAL": gltf.add("VEC3", normals)}, gltf.add(
        "SCALAR", indices, indices=True)  # fmt: skip


def turn(degrees):
    return (0.0, math.sin(math.radians(degrees) / 2), 0.0, math.cos(math.radians(degrees) / 2))


def make_materials(colours):
    """Those of {name: (colour, roughness, metallic)}, and one that emits."""
    materials = [{"name": name, "pbrMetallicRoughness": {"baseColorFactor": colour + [1], "roughnessFactor": rough,
                  "metallicFactor": metal}} for name, (colour, rough, metal) in colours.items()]  # fmt: skip
    materials.append({"name": "lamp", "emissiveFactor": [1, 0.9, 0.75],
                      "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]},
                      "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 22}}})  # fmt: skip
    return materials


CAMERA = {"name": "camera", "camera": 0, "translation": [0, 1.6, 5], "rotation": [-0.105, 0, 0, 0.9945]}


def write_gltf(path, gltf, roots, nodes, meshes, materials, animation, skins=None):
    document = {
        "asset": {"version": "2.0", "generator": "stillray examples/scenes/make_scenes.py",
                  "copyright": "the stillray developers, Apache-2.0"},
        "extensionsUsed": ["KHR_materials_emissive_strength"],
        "scene": 0,
        "scenes": [{"nodes": roots,
                    "extras": {"environment": {"type": "constant", "radiance": [0.12, 0.14, 0.18]}}}],
        "nodes": nodes, "meshes": meshes, "materials": materials, "animations": [animation],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.1}}],
        "accessors": gltf.accessors, "bufferViews": gltf.views,
        "buffers": [{"byteLength": len(gltf.bytes), "uri": "data:application/octet-stream;base64,"
                     + base64.b64encode(gltf.bytes).decode()}],
    }  # fmt: skip
    if skins:
        document["skins"] = skins
    path.write_text(json.dumps(document, indent=1) + "\n")


def write_turntable(folder):
    """A plate with three boxes that turns once in four seconds, under a lamp."""
    gltf = Gltf()
    attributes, indices = add_cube(gltf)
    colours = {"floor": ([0.6, 0.58, 0.55], 0.9, 0), "plate": ([0.35, 0.38, 0.42], 0.3, 1),
               "red": ([0.7, 0.1, 0.07], 0.6, 0), "blue": ([0.08, 0.2, 0.65], 0.35, 0),
               "copper": ([0.93, 0.55, 0.4], 0.2, 1)}  # fmt: skip
    materials = make_materials(colours)
    meshes = [{"primitives": [{"attributes": attributes, "indices": indices, "material": i}]}
              for i in range(len(materials))]  # fmt: skip
    nodes = [
        {"name": "floor", "mesh": 0, "translation": [0, -0.25, 0], "scale": [6, 0.1, 6]},
        {"name": "table", "children": [2, 3, 4, 5]},
        {"name": "plate", "mesh": 1, "translation": [0, -0.1, 0], "scale": [1.3, 0.05, 1.3]},
        {"name": "red", "mesh": 2, "translation": [0.6, 0.35, 0.2], "scale": [0.3, 0.4, 0.3]},
        {"name": "blue", "mesh": 3, "translation": [-0.6, 0.2, 0.4], "scale": [0.35, 0.25, 0.2]},
        {"name": "copper", "mesh": 4, "translation": [-0.1, 0.55, -0.6], "scale": [0.25, 0.6, 0.25],
         "rotation": turn(30)},
        {"name": "lamp", "mesh": 5, "translation": [1.5, 3.5, 1], "scale": [0.6, 0.02, 0.6]},
        CAMERA,
    ]  # fmt: skip
    animation = {"name": "turn", "channels": [{"sampler": 0, "target": {"node": 1, "path": "rotation"}}],
                 "samplers": [{"input": gltf.add("SCALAR", [0.0, 1.0, 2.0, 3.0, 4.0]),
                               "output": gltf.add("VEC4", [turn(90 * i) for i in range(5)])}]}  # fmt: skip
    write_gltf(folder / "turntable.gltf", gltf, [0, 1, 6, 7], nodes, meshes, materials, animation)


def add_grid(gltf, rows, columns, point, normal):
    """A surface of revolution: point(s, angle) and its normal for s from 0 to 1, closed around."""
    at = [(i / rows, 2 * math.pi * k / columns) for i in range(rows + 1) for k in range(columns + 1)]
    indices = []
    for i in range(rows):
        for k in range(columns):
            o = i * (columns + 1) + k
            indices += [o, o + columns + 1, o + columns + 2, o, o + columns + 2, o + 1]
    attributes = {"POSITION": gltf.add("VEC3", [point(s, t) for s, t in at]),
                  "NORMAL": gltf.add("VEC3", [normal(s, t) for s, t in at])}  # fmt: skip
    return at, attributes, gltf.add("SCALAR", indices, indices=True)


HEIGHT, JOINTS = 2.1, 4


def add_tube(gltf):
    """Upright, with joints one above the other; each vertex follows the two joints next to it."""

    def point(s, t):
        radius = 0.3 - 0.15 * s
        return (radius * math.sin(t), HEIGHT * s, radius * math.cos(t))

    def normal(_, t):
        slope = 0.15 / HEIGHT
        length = math.hypot(1, slope)
        return (math.sin(t) / length, slope / length, math.cos(t) / length)

    at, attributes, indices = add_grid(gltf, 20, 20, point, normal)
    joints, weights = [], []
    for s, _ in at:
        place = min(max(s * JOINTS - 0.5, 0), JOINTS - 1.001)
        lower = int(place)
        joints.append((lower, lower + 1, 0, 0))
        weights.append((1 - (place - lower), place - lower, 0, 0))
    attributes.update(JOINTS_0=gltf.add("VEC4", joints, indices=True), WEIGHTS_0=gltf.add("VEC4", weights))
    heights = [HEIGHT * j / JOINTS for j in range(JOINTS)]
    inverse = [(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -height, 0, 1) for height in heights]
    return {"attributes": attributes, "indices": indices, "material": 1}, gltf.add("MAT4", inverse)


def add_ball(gltf):
    """A sphere with one morph target: flatter and wider."""
    radius, scale = 0.4, (1.35, 0.55, 1.35)

    def normal(s, t):
        around = math.sin(math.pi * s)
        return (around * math.sin(t), -math.cos(math.pi * s), around * math.cos(t))

    at, attributes, indices = add_grid(
        gltf, 14, 20, lambda s, t: tuple(radius * n for n in normal(s, t)), normal)  # fmt: skip
    moved, turned_by = [], []
    for s, t in at:
        n = normal(s, t)
        flat = [n[axis] / scale[axis] for axis in range(3)]
        length = math.sqrt(sum(x * x for x in flat))
        moved.append(tuple(radius * n[axis] * (scale[axis] - 1) for axis in range(3)))
        turned_by.append(tuple(flat[axis] / length - n[axis] for axis in range(3)))
    target = {"POSITION": gltf.add("VEC3", moved), "NORMAL": gltf.add("VEC3", turned_by)}
    return {"attributes": attributes, "indices": indices, "material": 2, "targets": [target]}


def sway(joint, time):
    """The rotation of a joint, twice in four seconds from side to side, and once forwards."""
    side = math.radians(24) * math.sin(math.pi * time - 0.6 * joint)
    front = math.radians(12) * math.sin(math.pi * time / 2 - 0.4 * joint)
    x, z = math.sin(front / 2), math.sin(side / 2)
    return (x, 0.0, z, math.sqrt(1 - x * x - z * z))


def write_deforming(folder):
    """A tube that sways by its skin, and a ball that bounces and becomes flat by a morph target."""
    gltf = Gltf()
    attributes, indices = add_cube(gltf)
    tube, inverse = add_tube(gltf)
    ball = add_ball(gltf)
    materials = make_materials({"floor": ([0.6, 0.58, 0.55], 0.9, 0), "rubber": ([0.75, 0.22, 0.06], 0.45, 0),
                                "ball": ([0.1, 0.3, 0.65], 0.3, 0)})  # fmt: skip
    meshes = [{"primitives": [{"attributes": attributes, "indices": indices, "material": 0}]},
              {"primitives": [tube]}, {"primitives": [ball], "weights": [0]},
              {"primitives": [{"attributes": attributes, "indices": indices, "material": 3}]}]  # fmt: skip
    nodes = [
        {"name": "floor", "mesh": 0, "translation": [0, -0.25, 0], "scale": [6, 0.1, 6]},
        {"name": "tube", "mesh": 1, "skin": 0},
        {"name": "joint 0", "translation": [-0.5, -0.15, 0], "children": [3]},
    ]
    for joint in range(1, JOINTS):
        nodes.append({"name": "joint %d" % joint, "translation": [0, HEIGHT / JOINTS, 0]})
        if joint + 1 < JOINTS:
            nodes[-1]["children"] = [len(nodes)]
    ball_node = len(nodes)
    nodes += [{"name": "ball", "mesh": 2, "translation": [0.8, 0.25, 0.4]},
              {"name": "lamp", "mesh": 3, "translation": [1.5, 3.5, 1], "scale": [0.6, 0.02, 0.6]},
              CAMERA]  # fmt: skip
    samplers, channels = [], []

    def animate(node, path, times, output):
        channels.append({"sampler": len(samplers), "target": {"node": node, "path": path}})
        samplers.append({"input": times, "output": output})

    steps = [i / 8 for i in range(33)]
    times = gltf.add("SCALAR", steps)
    for joint in range(1, JOINTS):
        animate(2 + joint, "rotation", times, gltf.add("VEC4", [sway(joint, t) for t in steps]))
    # The ball lies on the floor at whole seconds, flat, and is highest between.
    height = [4 * (t % 1) * (1 - t % 1) for t in steps]
    flat = [max(0.0, 1 - 4 * h) for h in height]
    rest = [0.25 + 0.9 * h - 0.4 * 0.45 * f for h, f in zip(height, flat)]
    animate(ball_node, "translation", times, gltf.add("VEC3", [(0.8, y, 0.4) for y in rest]))
    animate(ball_node, "weights", times, gltf.add("SCALAR", flat))
    write_gltf(folder / "deforming.gltf", gltf, [0, 1, 2, ball_node, ball_node + 1, ball_node + 2], nodes, meshes,
               materials, {"name": "sway", "channels": channels, "samplers": samplers},
               [{"name": "tube", "joints": [2 + j for j in range(JOINTS)], "inverseBindMatrices": inverse}])  # fmt: skip


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).parent
    write_room(folder)
    write_turntable(folder)
    write_deforming(folder)


if __name__ == "__main__":
    main()
