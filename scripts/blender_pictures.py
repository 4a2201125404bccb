# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Makes the pictures of docs/blender.md in Blender's window; run by scripts/blender_pictures.sh.

    blender --factory-startup --python scripts/blender_pictures.py -- ADDON.zip PROGRAM WORK IMAGES
"""
import os
import pathlib
import sys
import traceback

import bpy
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from picture_files import write_png  # noqa: E402

ADDON, PROGRAM, WORK, IMAGES = sys.argv[sys.argv.index("--") + 1:][:4]
LAST = 24


def window():
    return bpy.context.window_manager.windows[0]


def area_of(kind):
    return max((a for a in window().screen.areas if a.type == kind), key=lambda a: a.width)


def override(area):
    region = next(r for r in area.regions if r.type == "WINDOW")
    return bpy.context.temp_override(window=window(), area=area, region=region)


def call(name, **named):
    with override(area_of("PROPERTIES")):
        return getattr(bpy.ops.stillray, name)("INVOKE_DEFAULT", True, **named)


def screen_pixels():
    """The window, top line first."""
    file = os.path.join(WORK, "screen.png")
    with override(area_of("PROPERTIES")):
        bpy.ops.screen.screenshot(filepath=file)
    image = bpy.data.images.load(file)
    width, height = image.size
    values = numpy.array(image.pixels[:]).reshape(height, width, 4)[::-1, :, :3]
    bpy.data.images.remove(image)
    return (values * 255 + 0.5).astype(numpy.uint8)


def crop(pixels, area, region="WINDOW"):
    r = next(r for r in area.regions if r.type == region)
    top = len(pixels) - r.y - r.height
    return pixels[top:top + r.height, r.x:r.x + r.width]


def without_empty_rows(pixels):
    """Cuts what lies under the last line that has content."""
    margin = 16  # of the rounded corners
    inside = pixels[:-margin, margin:-margin]
    rows = numpy.flatnonzero((inside != inside[-1]).any(axis=(1, 2)))
    return pixels[:rows[-1] + 8] if len(rows) else pixels


def write(name, pixels):
    write_png(pathlib.Path(IMAGES) / name, pixels)
    print(f"blender_pictures: {name}: {pixels.shape[1]}x{pixels.shape[0]}", flush=True)


def material(name, colour, roughness, metallic=0.0, checker=False):
    result = bpy.data.materials.new(name)
    result.use_nodes = True
    nodes, links = result.node_tree.nodes, result.node_tree.links
    principled = nodes["Principled BSDF"]
    principled.inputs["Base Color"].default_value = (*colour, 1)
    principled.inputs["Roughness"].default_value = roughness
    principled.inputs["Metallic"].default_value = metallic
    if checker:
        texture = nodes.new("ShaderNodeTexChecker")
        texture.inputs["Scale"].default_value = 12
        texture.inputs["Color1"].default_value = (*colour, 1)
        texture.inputs["Color2"].default_value = (0.75, 0.7, 0.62, 1)
        links.new(texture.outputs[0], principled.inputs["Base Color"])
    return result


def add(operator, name, look, smooth=False, **named):
    operator(**named)
    item = bpy.context.object
    item.name = name
    item.data.materials.append(look)
    for polygon in item.data.polygons if smooth else ():
        polygon.use_smooth = True
    return item


def make_scene():
    scene = bpy.context.scene
    bpy.data.objects.remove(scene.objects["Cube"])
    mesh = bpy.ops.mesh
    add(mesh.primitive_plane_add, "floor", material("tiles", (0.16, 0.11, 0.08), 0.5, checker=True),
        size=16)
    add(mesh.primitive_plane_add, "wall", material("plaster", (0.55, 0.25, 0.18), 0.9), size=16,
        location=(0, 4, 0), rotation=(1.5708, 0, 0))
    head = add(mesh.primitive_monkey_add, "head", material("red", (0.6, 0.06, 0.05), 0.25), True,
               size=2, location=(-1, 0, 1.05), rotation=(-0.2, 0, 0.5))
    head.modifiers.new("smooth", "SUBSURF").render_levels = 2
    add(mesh.primitive_uv_sphere_add, "ball", material("brass", (0.9, 0.65, 0.3), 0.2, 1.0), True,
        radius=0.8, location=(1.3, 0.2, 0.8), segments=64, ring_count=32)
    scene.objects["Light"].data.type = "AREA"
    lamp = scene.objects["Light"]
    lamp.data.energy, lamp.data.size = 700, 1.5
    lamp.location, lamp.rotation_euler = (3, -3, 5), (0.65, 0, 0.79)
    scene.world.node_tree.nodes["Background"].inputs[1].default_value = 0.4
    camera = scene.camera
    camera.data.lens = 40
    camera.rotation_euler = (1.25, 0, 0)
    for frame, x in ((0, -0.6), (LAST + 1, 0.6)):
        camera.location = (x, -6.5, 3)
        camera.keyframe_insert("location", frame=frame)
    for curve in camera.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    scene.frame_start, scene.frame_end = 1, LAST
    scene.render.resolution_x, scene.render.resolution_y = 640, 360
    bpy.ops.wm.save_as_mainfile(filepath=os.path.join(WORK, "shot.blend"))


def arrange():
    """Image editor on the left, the panel alone on the right."""
    view = area_of("VIEW_3D")
    with override(view):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.6)
    views = sorted((a for a in window().screen.areas if a.type == "VIEW_3D"), key=lambda a: a.x)
    views[0].type = "IMAGE_EDITOR"
    views[-1].type = "PROPERTIES"
    for cls in bpy.types.Panel.__subclasses__() + [
            c for base in bpy.types.Panel.__subclasses__() for c in base.__subclasses__()]:
        if getattr(cls, "bl_context", "") == "render" and "STILLRAY" not in cls.__name__:
            try:
                bpy.utils.unregister_class(cls)
            except RuntimeError:
                pass


def idle():
    while sys.modules["stillray_addon.operators"].active is not None:
        yield 0.2


def panel():
    return without_empty_rows(crop(screen_pixels(), area_of("PROPERTIES")))


def take():
    bpy.ops.preferences.addon_install(filepath=ADDON)
    bpy.ops.preferences.addon_enable(module="stillray_addon")
    bpy.context.preferences.view.render_display_type = "NONE"
    os.environ["STILLRAY"] = PROGRAM
    make_scene()
    arrange()
    yield 1
    area_of("PROPERTIES").spaces.active.context = "RENDER"
    yield 2
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    yield 1
    window().cursor_warp(300, 880)  # away from buttons, which would show their tips
    yield 1
    write("blender_warnings.png", panel())
    call("prepare")
    scene.stillray.show_changes = True
    yield 1
    write("blender_prepare.png", panel())
    scene.stillray.show_changes = False
    call("render")
    operators = sys.modules["stillray_addon.operators"]
    taken = False
    while operators.active is not None:
        if not taken and operators.active.text.startswith("Denoising: frame") and \
                operators.active.fraction > 0.1:
            pixels = screen_pixels()
            bar = pixels[-22:, :area_of("PROPERTIES").width + 90]
            parts = crop(pixels, area_of("PROPERTIES"))[:260]
            width = min(parts.shape[1], bar.shape[1])
            write("blender_progress.png", numpy.concatenate([parts[:, :width], bar[:, :width]]))
            taken = True
        yield 0.1
    editor = area_of("IMAGE_EDITOR")
    scene.frame_set(12)
    shots = []
    for name in ("show", "toggle"):
        call(name)
        if name == "show":
            with override(editor):
                bpy.ops.image.view_all(fit_view=False)
                bpy.ops.image.view_zoom_ratio(ratio=1)
            editor.spaces.active.show_gizmo = False
        yield 1.5
        shots.append(crop(screen_pixels(), editor))
    clean, noisy = shots
    middle = clean.shape[1] // 2
    both = clean.copy()
    both[:, :middle - 1] = noisy[:, :middle - 1]
    both[:, middle - 1:middle + 1] = 255
    height, width = 356, 600  # without the editor's borders
    top, left = (both.shape[0] - height) // 2, (both.shape[1] - width) // 2
    write("blender_result.png", both[top:top + height, left:left + width])
    scene.render.filepath, scene.frame_end = "//render/fixed.####", 6
    scene.cycles.use_animated_seed = False
    call("render")
    yield from idle()
    yield 1
    write("blender_findings.png", panel())


steps = take()


def tick():
    try:
        return next(steps)
    except StopIteration:
        os._exit(0)
    except BaseException:
        traceback.print_exc()
        sys.stdout.flush()
        os._exit(1)


os.makedirs(WORK, exist_ok=True)
bpy.context.preferences.view.show_splash = False  # before Blender shows it
bpy.app.timers.register(tick, first_interval=1.0, persistent=True)
