# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Which settings of a scene `stillray` needs, and what stands against it."""
import os

import bpy

from . import paths, settings, versions


def resolver(scene):
    """Objects by paths from the scene, or from bpy.data with `data.` before it."""
    def resolve(owner):
        if not owner:
            return scene
        if owner.startswith("data."):
            return bpy.data.path_resolve(owner[len("data."):])
        return scene.path_resolve(owner)
    return resolve


def layer_path(layer):
    return f'view_layers["{bpy.utils.escape_identifier(layer.name)}"]'


def camera_path(camera):
    return f'data.cameras["{bpy.utils.escape_identifier(camera.name)}"].dof'


def cameras_of(scene):
    """The scene's camera, and those that markers switch to."""
    objects = [scene.camera] + [marker.camera for marker in scene.timeline_markers]
    found = []
    for camera in objects:
        if camera is not None and camera.type == "CAMERA" and camera not in found:
            found.append(camera)
    return found


def has_volumes(scene):
    def tree_has(tree):
        return tree is not None and any(
            node.bl_idname in ("ShaderNodeOutputMaterial", "ShaderNodeOutputWorld")
            and node.inputs["Volume"].is_linked for node in tree.nodes)

    if scene.world is not None and tree_has(scene.world.node_tree):
        return True
    for item in scene.objects:
        if item.type == "VOLUME":
            return True
        for slot in item.material_slots:
            if slot.material is not None and tree_has(slot.material.node_tree):
                return True
    return False


def _pass_settings(scene, volumes=None):
    volumes = has_volumes(scene) if volumes is None else volumes
    wanted = []
    for layer in scene.view_layers:
        if layer.use:
            for owner, name in versions.pass_properties(layer, volumes):
                path = layer_path(layer) + (f".{owner}" if owner else "")
                wanted.append((path, name, True))
    return wanted


def _format_settings(scene):
    return [("render.image_settings", name, value)
            for name, value in versions.multilayer_settings(scene.render.image_settings)]


def _output_settings(scene):
    wanted = _format_settings(scene)
    wanted.append(("render", "use_file_extension", True))
    if paths.is_default_output(scene.render.filepath, _temporary_folders()):
        wanted.append(("render", "filepath", paths.default_output(
            bpy.data.filepath, scene.name, len(bpy.data.scenes) > 1)))
    return wanted


def _temporary_folders():
    return [bpy.app.tempdir, bpy.context.preferences.filepaths.temporary_directory]


# From this number of samples on, antialiased guides lose less than jagged edges do (docs/blender.md).
# One sample goes through the centre whatever the filter.
_SMOOTH_SAMPLES = 2


def _filter_settings(scene):
    values = scene.stillray
    smooth = values.edges == "SMOOTH" or (values.edges == "AUTO"
                                          and values.samples >= _SMOOTH_SAMPLES)
    width = 1.5 if smooth else 0.01
    return [("cycles", "pixel_filter_type", "BLACKMAN_HARRIS"), ("cycles", "filter_width", width)]


def wanted(scene):
    """[(owner, name, value)] that Prepare sets, in order. Raises ValueError without Cycles."""
    if not hasattr(scene, "cycles"):
        raise ValueError("Cycles is not there: turn on the add-on Cycles Render Engine")
    render = [("render", "engine", "CYCLES"), ("render", "use_motion_blur", False)]
    if versions.compositor_is_on(scene):
        render.append(("render", "use_compositing", False))
    if versions.has_strips(scene):
        render.append(("render", "use_sequencer", False))
    cycles = [("cycles", "use_animated_seed", True), ("cycles", "use_adaptive_sampling", False),
              ("cycles", "use_denoising", False), ("cycles", "time_limit", 0.0),
              ("cycles", "samples", scene.stillray.samples)]
    return (render + _output_settings(scene) + cycles + _filter_settings(scene)
            + _pass_settings(scene))


def _also_changed(scene):
    names = versions.image_format_properties(scene.render.image_settings)
    return [("render.image_settings", name) for name in names]


def change(scene, wanted_settings):
    """Sets them, keeps the old values in the scene, and returns (changes, names that failed)."""
    changes, failed = settings.apply(wanted_settings, resolver(scene), _also_changed(scene))
    saved = settings.merge(settings.load(scene.stillray.saved), changes)
    scene.stillray.saved = settings.dump(saved)
    return changes, failed


def restore(scene):
    undone, left = settings.restore(settings.load(scene.stillray.saved), resolver(scene))
    scene.stillray.saved = ""
    scene.stillray.prepared = False
    return undone, left


def _depth_of_field(scene):
    return [(camera_path(c.data), "use_dof", False) for c in cameras_of(scene)]


# What cures a finding of `stillray check`, or a warning: label of the button, settings.
CURES = {
    "fixed_seed": ("Change the seed with the frame",
                   lambda scene: [("cycles", "use_animated_seed", True)]),
    "frames_repeated": ("Change the seed with the frame",
                        lambda scene: [("cycles", "use_animated_seed", True)]),
    "motion_zero": ("Turn motion blur off, pass Vector on",
                    lambda scene: [("render", "use_motion_blur", False), *_pass_settings(scene)]),
    "motion_blur": ("Turn motion blur off", lambda scene: [("render", "use_motion_blur", False)]),
    "denoiser": ("Turn Denoise off", lambda scene: [("cycles", "use_denoising", False)]),
    "adaptive": ("Turn Noise Threshold off",
                 lambda scene: [("cycles", "use_adaptive_sampling", False)]),
    "compositor": ("Turn compositing off", lambda scene: [("render", "use_compositing", False)]),
    "sequencer": ("Turn the sequencer off", lambda scene: [("render", "use_sequencer", False)]),
    "format": ("Use OpenEXR MultiLayer", _output_settings),
    "single_layer": ("Use OpenEXR MultiLayer", _output_settings),
    "lossy_compression": ("Use the codec ZIP", _format_settings),
    "view_layer_left": ("Denoise all view layers",
                        lambda scene: [("stillray", "all_layers", True)]),
    "first_hits_random": ("Turn depth of field off", _depth_of_field),
    "depth_of_field": ("Turn depth of field off", _depth_of_field),
    "albedo_noisy": ("Use a narrow pixel filter", lambda scene: [
        ("stillray", "edges", "STABLE"), ("cycles", "pixel_filter_type", "BLACKMAN_HARRIS"),
        ("cycles", "filter_width", 0.01)]),
    "passes_do_not_add_up": ("Turn compositing and Denoise off", lambda scene: [
        ("render", "use_compositing", False), ("cycles", "use_denoising", False)]),
    "light_clamped": ("Turn clamping of direct light off",
                      lambda scene: [("cycles", "sample_clamp_direct", 0.0)]),
}
for _name in ("motion_missing", "depth_missing", "normal_missing", "albedo_missing",
              "passes_missing", "layers_change"):
    CURES[_name] = ("Turn the passes on", _pass_settings)
for _name in ("normal_noisy", "depth_noisy"):
    CURES[_name] = CURES["albedo_noisy"]

# What to say where the settings of the cure are as they should be.
WITHOUT_SETTING = {
    "first_hits_random": "Fog: turn the Volume passes on. Hair: use 16 samples or more. "
                         "Transparent materials: render them in a view layer of their own, or "
                         "use more samples",
    "frames_repeated": "Frames are copies of each other: fine if nothing moves, else render again",
    "light_clamped": "Light is limited to a largest value: raise Light Paths > Clamping",
}

# Cures that need no new frames.
WITHOUT_RENDERING = {"view_layer_left"}


def can_cure(scene, name):
    """False if the settings are as the cure would set them."""
    if name not in CURES:
        return False
    resolve = resolver(scene)
    for owner, attribute, value in CURES[name][1](scene):
        try:
            if not settings.same(getattr(resolve(owner), attribute), value):
                return True
        except (AttributeError, KeyError, ValueError, TypeError):
            continue
    return False


class Obstacle:
    def __init__(self, name, text, blocks=False):
        self.name = name
        self.text = text
        self.blocks = blocks  # frames could not be used at all


def warnings(scene):
    """What stands against denoising in the scene as it is. For the panel: reads settings only."""
    render, found = scene.render, []

    def add(name, text, blocks=False):
        found.append(Obstacle(name, text, blocks))

    if not hasattr(scene, "cycles"):
        add("engine", "Cycles is not there: turn on the add-on Cycles Render Engine", True)
        return found
    if render.engine != "CYCLES":
        add("engine", "Only frames of Cycles can be denoised", True)
    if not versions.is_multilayer(scene):
        add("format", "The output is not OpenEXR MultiLayer: passes are lost", True)
    if scene.camera is None:
        add("camera", "The scene has no camera", True)
    if render.use_motion_blur:
        add("motion_blur", "Motion blur: Cycles then writes no motion vectors")
    if not scene.cycles.use_animated_seed and scene.frame_end > scene.frame_start:
        add("fixed_seed", "Fixed seed: every frame repeats the same noise")
    if scene.cycles.use_denoising:
        add("denoiser", "Denoise is on: it costs time, and is not needed")
    if scene.cycles.use_adaptive_sampling:
        add("adaptive", "Noise Threshold is on: the number of samples differs between pixels")
    if versions.compositor_is_on(scene):
        add("compositor", "The compositor is on: it changes the output of Render Animation")
    if render.use_sequencer and versions.has_strips(scene):
        add("sequencer", "The sequencer has strips: Render Animation writes them, not the scene")
    if any(c.data.dof.use_dof for c in cameras_of(scene)):
        add("depth_of_field", "Depth of field: blurred parts keep noise; defocus in the compositor")
    if render.use_multiview:
        add("stereo", "Stereoscopy: only single views can be denoised", True)
    if scene.frame_step != 1:
        add("step", f"Frame step {scene.frame_step}: motion does not lead to the frame before")
    if len(missing_passes(scene)) > 0:
        add("passes_missing", "Passes are missing: " + ", ".join(missing_passes(scene)[:4]))
    return found


def missing_passes(scene):
    """Without those of volumes: the panel calls this, and must not look at every object."""
    resolve, names = resolver(scene), []
    for owner, name, value in _pass_settings(scene, volumes=False):
        if getattr(resolve(owner), name) != value:
            names.append(settings.title(name).replace("Pass ", "", 1))
    return list(dict.fromkeys(names))


def frame_names(scene):
    """Names of the frames that the scene renders. Raises ValueError."""
    if scene.render.filepath.startswith("//") and not bpy.data.filepath:
        raise ValueError("Save the file first: the output path is relative to it")

    def path_of(frame):
        path = bpy.path.abspath(scene.render.frame_path(frame=frame))
        return os.path.abspath(path)
    return paths.FrameNames.probe(path_of)
