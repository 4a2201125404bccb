# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Renders short shots with what makes guides random: a lens, a shutter, smoke, fur. In Blender 3.4 or newer:

  blender -b --factory-startup -P scripts/blender_shots.py -- --shot smoke --samples 4 --out shots/smoke

writes shots/smoke/noisy.0001.exr and so on, with all passes that `stillray denoise` can use, and
reference.####.exr of the frames of --judged. Shots:

  room     a tiled room with a metal ball, a table and a sliding cube; still camera settings
  lamp     the same, lit by a small lamp that moves through it: highlights and shadows move
  heads    another room: heads of gold, steel, plastic and plaster, poles and a small moving lamp
  mirror   the room with a mirror on the wall, a glass ball and a pane of glass
  curved   the room with a chrome ball, a chrome vase, a glass ball and a glass head
  lens     the same, out of focus behind and before the cube
  shutter  the same with motion blur: Vector is zero
  smoke    the same with smoke that moves
  cloud    smoke and a ball before a sky (--transparent: under a transparent film)
  fur      a ball of hair that turns, and another ball (--transparent likewise)
"""
import argparse
import math
import pathlib
import random
import sys

import bpy
from mathutils import Vector

LAST = 24  # of every movement


def arguments():
    parser = argparse.ArgumentParser(prog="blender_shots.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shot", required=True, choices=sorted(SHOTS))
    parser.add_argument("--out", required=True, type=pathlib.Path, help="folder, made if needed")
    parser.add_argument("--samples", default=16, type=int, help="per pixel (default: 16)")
    parser.add_argument("--size", default="256x144", help="default: 256x144")
    parser.add_argument("--frames", default=12, type=int, help="default: 12")
    parser.add_argument("--judged", default="8", help="frames with references, such as 8,12")
    parser.add_argument("--reference", default=768, type=int, help="samples of references")
    parser.add_argument("--filter-width", default=1.5, type=float,
                        help="of Blender's pixel filter (default: 1.5); 0.01: all rays through centres")
    parser.add_argument("--transparent", action="store_true")
    parser.add_argument("--blur", type=float, metavar="PART",
                        help="how much of a frame the shutter is open (default: 0.8 in shutter, else 0)")
    parser.add_argument("--speed", default=1, type=float, help="of all movements (default: 1)")
    return parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])


def material(name, colour, roughness=0.7, metallic=0.0, checker=None):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    surface = nodes["Principled BSDF"]
    surface.inputs["Base Color"].default_value = (*colour, 1)
    surface.inputs["Roughness"].default_value = roughness
    surface.inputs["Metallic"].default_value = metallic
    if checker is not None:
        other, scale = checker
        place, texture = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeTexChecker")
        texture.inputs["Color1"].default_value = (*colour, 1)
        texture.inputs["Color2"].default_value = (*other, 1)
        texture.inputs["Scale"].default_value = scale
        links.new(place.outputs["Object"], texture.inputs["Vector"])
        links.new(texture.outputs["Color"], surface.inputs["Base Color"])
    return made


def add(kind, name, place, size, look, index, turn=(0, 0, 0)):
    """A primitive, scaled to these sizes, with its own object index."""
    getattr(bpy.ops.mesh, f"primitive_{kind}_add")(location=place, rotation=turn)
    made = bpy.context.object
    made.name, made.pass_index, made.scale = name, index, size
    if kind.endswith("sphere"):
        bpy.ops.object.shade_smooth()
    made.data.materials.append(look)
    return made


def move(thing, path, start, end):
    for frame, value in ((0, start), (LAST + 1, end)):
        setattr(thing, path, value)
        thing.keyframe_insert(path, frame=frame)
    for curve in thing.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"


def lamp(place, aim, watts, size):
    data = bpy.data.lights.new("lamp", "AREA")
    data.energy, data.size = watts, size
    thing = bpy.data.objects.new("lamp", data)
    bpy.context.collection.objects.link(thing)
    thing.location = place
    thing.rotation_euler = (Vector(aim) - Vector(place)).to_track_quat("-Z", "Y").to_euler()
    return thing


def camera(start, end, aim, lens=28):
    thing = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    bpy.context.collection.objects.link(thing)
    thing.data.lens = lens
    bpy.context.scene.camera = thing
    move(thing, "location", start, end)
    thing.rotation_euler = (Vector(aim) - Vector(start)).to_track_quat("-Z", "Y").to_euler()
    return thing


def world(colour, sky=False):
    made = bpy.data.worlds.new("world")
    bpy.context.scene.world = made
    made.use_nodes = True
    nodes = made.node_tree.nodes
    nodes["Background"].inputs["Color"].default_value = (*colour, 1)
    if sky:
        texture = nodes.new("ShaderNodeTexSky")
        texture.sky_type = "HOSEK_WILKIE"
        texture.sun_direction = (0.3, 0.5, 0.6)
        made.node_tree.links.new(texture.outputs["Color"], nodes["Background"].inputs["Color"])


def room():
    world((0, 0, 0))
    up, flat = math.pi / 2, 0.001
    plaster = material("plaster", (0.72, 0.71, 0.68), 0.9)
    tiles = material("tiles", (0.6, 0.48, 0.36), 0.35, checker=((0.2, 0.15, 0.11), 4))
    add("cube", "floor", (0, 4, 0), (3, 4, flat), tiles, 1)
    add("cube", "ceiling", (0, 4, 3), (3, 4, flat), plaster, 2)
    add("cube", "front", (0, 0, 1.5), (3, 1.5, flat), plaster, 3, (up, 0, 0))
    add("cube", "back", (0, 8, 1.5), (3, 1.5, flat),
        material("bricks", (0.5, 0.22, 0.15), 0.85, checker=((0.58, 0.55, 0.5), 14)), 4, (up, 0, 0))
    add("cube", "left", (-3, 4, 1.5), (4, 1.5, flat),
        material("paper", (0.25, 0.4, 0.55), 0.9, checker=((0.7, 0.72, 0.66), 9)), 5, (up, 0, up))
    add("cube", "right", (3, 4, 1.5), (4, 1.5, flat), material("green", (0.3, 0.55, 0.28), 0.9), 6, (up, 0, up))
    add("uv_sphere", "metal", (1.2, 5.4, 0.6), (0.6, 0.6, 0.6), material("metal", (0.82, 0.82, 0.85), 0.2, 1), 7)
    wood = material("wood", (0.4, 0.22, 0.1), 0.5)
    add("cube", "table", (-1.3, 5.2, 0.75), (0.9, 0.5, 0.03), wood, 8)
    for i, (x, y) in enumerate(((-2.1, 4.8), (-0.5, 4.8), (-2.1, 5.6), (-0.5, 5.6))):
        add("cube", f"leg{i}", (x, y, 0.36), (0.03, 0.03, 0.36), wood, 9 + i)
    add("monkey", "head", (-1.5, 5.1, 1.1), (0.34, 0.34, 0.34), material("plastic", (0.7, 0.08, 0.06), 0.2), 13)
    cube = add("cube", "cube", (-1, 3.8, 0.25), (0.25, 0.25, 0.25),
               material("check", (0.8, 0.75, 0.2), 0.7, checker=((0.1, 0.1, 0.12), 3)), 14)
    move(cube, "location", (-1.2, 3.8, 0.25), (1.2, 3.6, 0.25))
    move(cube, "rotation_euler", (0, 0, 0.4), (0, 0, -0.9))
    light = lamp((0.3, 4.2, 2.95), (0.3, 4.2, 0), 160, 1.0)
    return camera((0.3, 0.5, 1.55), (-0.1, 1.2, 1.45), (0, 5.5, 0.9), 26), cube, light


def moving_lamp():
    light = room()[2]
    light.data.energy, light.data.size = 90, 0.3
    move(light, "location", (-1.8, 3.4, 2.4), (1.6, 4.9, 1.9))


def heads():
    world((0.01, 0.01, 0.012))
    up, flat = math.pi / 2, 0.001
    add("cube", "floor", (0, 4, 0), (4, 5, flat),
        material("floor", (0.55, 0.5, 0.42), 0.5, checker=((0.3, 0.28, 0.3), 6)), 1)
    add("cube", "ceiling", (0, 4, 3.2), (4, 5, flat), material("ceiling", (0.7, 0.7, 0.7), 0.9), 2)
    add("cube", "back", (0, 8.5, 1.6), (4, 1.6, flat),
        material("wall", (0.62, 0.6, 0.55), 0.9, checker=((0.5, 0.42, 0.36), 11)), 3, (up, 0, 0))
    add("cube", "left", (-3.6, 4, 1.6), (5, 1.6, flat), material("red", (0.6, 0.25, 0.2), 0.9), 4, (up, 0, up))
    add("cube", "right", (3.6, 4, 1.6), (5, 1.6, flat), material("blue", (0.25, 0.35, 0.6), 0.9), 5, (up, 0, up))
    add("cube", "front", (0, -0.8, 1.6), (4, 1.6, flat), material("grey", (0.6, 0.6, 0.6), 0.9), 6, (up, 0, 0))
    gold, steel = material("gold", (0.9, 0.65, 0.25), 0.3, 1), material("steel", (0.7, 0.7, 0.72), 0.15, 1)
    plastic, plaster = material("plastic", (0.1, 0.2, 0.7), 0.15), material("plaster", (0.75, 0.73, 0.7), 0.95)
    for i, (x, y, z, size, look) in enumerate(((-1.5, 5.0, 0.8, 0.55, gold), (0.2, 5.8, 0.9, 0.6, plastic),
                                               (1.7, 4.8, 0.7, 0.5, plaster), (0.6, 3.9, 0.35, 0.3, steel))):
        head = add("monkey", f"head{i}", (x, y, z), (size, size, size), look, 10 + i, (0, 0, 0.3 * (i - 1)))
        bpy.ops.object.modifier_add(type="SUBSURF")
        head.modifiers[-1].levels = head.modifiers[-1].render_levels = 2
        bpy.ops.object.shade_smooth()
    bright, dark = material("pole", (0.8, 0.8, 0.78), 0.4), material("dark", (0.1, 0.1, 0.1), 0.3, 1)
    for i in range(9):
        add("cylinder", f"pole{i}", (0.7 * i - 2.8, 6.8, 1.6), (0.03, 0.03, 1.6), bright if i % 2 else dark, 20 + i)
    add("torus", "ring", (-0.6, 4.0, 0.35), (0.35, 0.35, 0.35), steel, 40, (1.2, 0, 0.4))
    add("cylinder", "column", (2.6, 6.2, 1.6), (0.3, 0.3, 1.6), plaster, 41)
    cube = add("cube", "cube", (-2.2, 3.8, 0.3), (0.25, 0.25, 0.25), plastic, 42)
    move(cube, "location", (-2.4, 3.6, 0.3), (0.6, 3.2, 0.3))
    data = bpy.data.lights.new("bulb", "POINT")
    data.energy, data.shadow_soft_size = 110, 0.08
    bulb = bpy.data.objects.new("bulb", data)
    bpy.context.collection.objects.link(bulb)
    move(bulb, "location", (-2.2, 4.2, 2.2), (2.4, 4.6, 1.7))
    lamp((0, 4, 3.15), (0, 4, 0), 20, 2)
    camera((-0.2, 0.2, 1.6), (0.2, 0.9, 1.5), (0, 5.5, 0.85), 26)


def clear(name, colour, metallic, transmission):
    made = material(name, colour, 0, metallic)
    inputs = made.node_tree.nodes["Principled BSDF"].inputs
    name = "Transmission Weight" if "Transmission Weight" in inputs else "Transmission"  # from Blender 4 on
    inputs[name].default_value = transmission
    return made


def mirror():
    room()
    up = math.pi / 2
    silver = clear("silver", (0.9, 0.9, 0.9), 1, 0)
    glass = clear("glass", (0.95, 0.98, 0.96), 0, 1)
    add("cube", "mirror", (2.97, 5.2, 1.5), (1.3, 0.8, 0.01), silver, 20, (up, 0, up))
    add("uv_sphere", "glass", (0.2, 4.3, 0.4), (0.4, 0.4, 0.4), glass, 21)
    add("cube", "pane", (-1.9, 3.9, 0.7), (0.5, 0.5, 0.01), glass, 22, (up, 0, 0.5))


def curved():
    room()
    chrome, glass = clear("chrome", (0.9, 0.9, 0.92), 1, 0), clear("glass", (0.95, 0.98, 0.96), 0, 1)
    add("uv_sphere", "chrome", (0.75, 4.6, 0.45), (0.45, 0.45, 0.45), chrome, 20)
    vase = add("cylinder", "vase", (-0.75, 4.5, 0.5), (0.3, 0.3, 0.5), chrome, 21)
    head = add("monkey", "glass", (0, 3.7, 0.45), (0.35, 0.35, 0.35), glass, 22, (0, 0, 0.4))
    bead = add("uv_sphere", "bead", (-0.15, 5.2, 0.7), (0.35, 0.35, 0.35), glass, 23)
    for thing in (head, vase):
        bpy.context.view_layer.objects.active = thing
        bpy.ops.object.modifier_add(type="SUBSURF" if thing is head else "BEVEL")
    head.modifiers[-1].levels = head.modifiers[-1].render_levels = 2
    vase.modifiers[-1].width, vase.modifiers[-1].segments = 0.08, 6
    for thing in (head, vase, bead):
        thing.select_set(True)
        bpy.context.view_layer.objects.active = thing
        bpy.ops.object.shade_smooth()


def lens():
    eye, cube, _ = room()
    eye.data.dof.use_dof = True
    eye.data.dof.aperture_fstop = 0.7
    eye.data.dof.focus_object = cube


def blur(part):
    bpy.context.scene.render.use_motion_blur = part > 0
    bpy.context.scene.render.motion_blur_shutter = max(part, 0.01)  # Blender's least


def shutter():
    room()
    blur(0.8)


def add_smoke():
    look = bpy.data.materials.new("smoke")
    look.use_nodes = True
    nodes, links = look.node_tree.nodes, look.node_tree.links
    nodes.clear()
    out, volume = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeVolumePrincipled")
    place, noise = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeTexNoise")
    density = nodes.new("ShaderNodeMapRange")
    noise.noise_dimensions = "4D"
    noise.inputs["Scale"].default_value = 2.2
    time = noise.inputs["W"]
    for frame, value in ((0, 0.0), (LAST + 1, 0.6)):
        time.default_value = value
        time.keyframe_insert("default_value", frame=frame)
    density.inputs["From Min"].default_value = 0.45
    density.inputs["From Max"].default_value = 0.75
    density.inputs["To Max"].default_value = 6
    links.new(place.outputs["Object"], noise.inputs["Vector"])
    links.new(noise.outputs["Fac"], density.inputs["Value"])
    links.new(density.outputs[0], volume.inputs["Density"])
    links.new(volume.outputs[0], out.inputs["Volume"])
    add("cube", "smoke", (0.2, 4.6, 1.0), (0.9, 0.7, 0.8), look, 40)


def smoke():
    room()
    add_smoke()


def add_ball(place, radius):
    add("uv_sphere", "ball", place, (radius, radius, radius), material("red", (0.7, 0.08, 0.06), 0.3), 3)


def cloud():
    world((0.3, 0.35, 0.4), sky=True)
    add_smoke()
    add_ball((1.0, 4.2, 0.5), 0.35)
    lamp((2.5, 2, 4), (0, 5, 1), 400, 0.8)
    camera((0.3, 0.8, 1.5), (-0.3, 1.0, 1.4), (0.2, 5, 0.9), 32)


def fur():
    """Hair as curves: particles differ from one start of Blender to the next."""
    world((0.35, 0.4, 0.5))
    chance = random.Random(5)
    hair = bpy.data.curves.new("hair", "CURVE")
    hair.dimensions, hair.bevel_depth, hair.bevel_resolution = "3D", 0.0045, 1
    hair.materials.append(material("hair", (0.55, 0.32, 0.12), 0.4))
    for _ in range(7000):
        height, angle = chance.uniform(-1, 1), chance.uniform(0, 2 * math.pi)
        across = math.sqrt(1 - height * height)
        root = Vector((across * math.cos(angle), across * math.sin(angle), height))
        bend = Vector([chance.gauss(0, 0.12) for _ in range(3)]) + Vector((0, 0, -0.25))
        bend += 0.2 * Vector([math.sin(9 * root[i] + i) for i in range(3)])
        spline = hair.splines.new("POLY")
        spline.points.add(3)
        for i, point in enumerate(spline.points):
            along = i / 3
            point.co = (*(root * (0.68 + 0.38 * along) + bend * (0.5 * along * along)), 1)
            point.radius = 1 - 0.85 * along
    coat = bpy.data.objects.new("coat", hair)
    bpy.context.collection.objects.link(coat)
    coat.pass_index = 2
    skin = add("uv_sphere", "skin", (0, 5, 1), (0.7, 0.7, 0.7), material("skin", (0.5, 0.3, 0.15)), 1)
    coat.location = skin.location
    move(coat, "rotation_euler", (0, 0, 0), (0, 0, 0.9))
    add_ball((1.2, 4.6, 0.5), 0.4)
    lamp((2.5, 2, 4), (0, 5, 1), 250, 0.8)
    camera((0.3, 0.8, 1.5), (-0.3, 1.0, 1.4), (0.2, 5, 0.9), 32)


SHOTS = {"room": room, "lamp": moving_lamp, "heads": heads, "mirror": mirror, "curved": curved, "lens": lens,
         "shutter": shutter, "smoke": smoke, "cloud": cloud, "fur": fur}


def set_up(options):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.use_animated_seed = True
    scene.render.resolution_x, scene.render.resolution_y = map(int, options.size.split("x"))
    scene.render.resolution_percentage = 100
    scene.cycles.filter_width = options.filter_width
    scene.render.film_transparent = options.transparent
    image = scene.render.image_settings
    if hasattr(image, "media_type"):  # Blender 5
        image.media_type = "MULTI_LAYER_IMAGE"
    image.file_format, image.color_depth, image.exr_codec = "OPEN_EXR_MULTILAYER", "16", "ZIP"
    layer = scene.view_layers[0]
    names = ["combined", "z", "normal", "vector", "object_index", "emit", "environment"]
    names += [f"{kind}_{part}" for kind in ("diffuse", "glossy", "transmission")
              for part in ("direct", "indirect", "color")]
    for name in names:
        setattr(layer, f"use_pass_{name}", True)
    layer.cycles.denoising_store_passes = True
    layer.cycles.use_pass_volume_direct = layer.cycles.use_pass_volume_indirect = True


def hasten(speed):
    for action in bpy.data.actions:
        for curve in action.fcurves:
            for key in curve.keyframe_points:
                key.co.x /= speed


def render(frame, samples, seed, path):
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.seed = samples, seed
    scene.frame_set(frame)
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    if not path.exists():
        sys.exit(f"Blender has not written {path}")
    print(f"wrote {path}", flush=True)


def main():
    options = arguments()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    SHOTS[options.shot]()
    hasten(options.speed)
    if options.blur is not None:
        blur(options.blur)
    set_up(options)
    options.out.mkdir(parents=True, exist_ok=True)
    for frame in range(1, options.frames + 1):
        render(frame, options.samples, 0, options.out / f"noisy.{frame:04d}.exr")
    for frame in (int(text) for text in options.judged.split(",") if text):
        render(frame, options.reference, 1000, options.out / f"reference.{frame:04d}.exr")


main()
