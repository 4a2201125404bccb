# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""All differences between Blender 3.4 and 5.x.

Each function asks for the property or type itself and not for a version number, so that it holds
for versions between and after those that were tried.
"""
import bpy

# Passes that `stillray denoise` uses, by the names of their properties. Property names are the same
# from 3.4 to 5.x; names of the passes in files are not, and the program reads both.
_PASSES = (
    "combined", "z", "vector", "normal", "emit", "environment", "cryptomatte_object",
    "diffuse_direct", "diffuse_indirect", "diffuse_color",
    "glossy_direct", "glossy_indirect", "glossy_color",
    "transmission_direct", "transmission_indirect", "transmission_color")
_CYCLES_PASSES = ("denoising_store_passes",)
_VOLUME_PASSES = ("use_pass_volume_direct", "use_pass_volume_indirect")


def pass_properties(layer, volumes):
    """[(name of the owner within the view layer, property)] of the passes to turn on."""
    wanted = [("", f"use_pass_{name}") for name in _PASSES]
    wanted += [("cycles", name) for name in _CYCLES_PASSES]
    if volumes:
        # Of the add-on Cycles in all versions so far; asked for on both.
        owners = (("cycles", layer.cycles), ("", layer))
        for name in _VOLUME_PASSES:
            wanted += [(owner, name) for owner, data in owners if hasattr(data, name)][:1]
    return [(owner, name) for owner, name in wanted
            if hasattr(getattr(layer, owner) if owner else layer, name)]


def multilayer_settings(image_settings):
    """[(property, value)] in the order in which they must be set: in 5.0 the kind of media decides
    which formats there are. 5.0 also writes one part per pass unless told otherwise."""
    wanted = [("media_type", "MULTI_LAYER_IMAGE"), ("file_format", "OPEN_EXR_MULTILAYER"),
              ("color_depth", "16"), ("exr_codec", "ZIP"), ("use_exr_interleave", True)]
    return [(name, value) for name, value in wanted if hasattr(image_settings, name)]


def image_format_properties(image_settings):
    """Properties that change with the file format."""
    names = ("media_type", "file_format", "color_mode", "color_depth", "exr_codec", "quality",
             "compression", "use_exr_interleave", "use_preview")
    return [name for name in names if hasattr(image_settings, name)]


def is_multilayer(scene):
    return scene.render.image_settings.file_format == "OPEN_EXR_MULTILAYER"


def compositor_tree(scene):
    """The node tree of the compositor, or None. A node group of its own since 5.0."""
    if hasattr(scene, "compositing_node_group"):
        return scene.compositing_node_group
    return scene.node_tree if scene.use_nodes else None


def compositor_is_on(scene):
    tree = compositor_tree(scene)
    return bool(scene.render.use_compositing and tree is not None and len(tree.nodes) > 0)


def ensure_compositor_tree(scene):
    """The node tree, made with Render Layers and an output if there is none."""
    tree = compositor_tree(scene)
    if tree is not None:
        return tree
    if not hasattr(scene, "compositing_node_group"):
        scene.use_nodes = True  # makes both nodes
        return scene.node_tree
    tree = bpy.data.node_groups.new(scene.name + " Compositing", "CompositorNodeTree")
    scene.compositing_node_group = tree
    layers = tree.nodes.new("CompositorNodeRLayers")
    layers.location = (-300, 0)
    tree.links.new(layers.outputs[0], compositor_output(tree).inputs[0])
    return tree


def compositor_output(tree):
    """The node whose first input is the picture: Composite, and since 5.0 the group's output."""
    if hasattr(bpy.types, "CompositorNodeComposite"):
        kind = "CompositorNodeComposite"
    else:
        kind = "NodeGroupOutput"
        if not any(item.item_type == "SOCKET" and item.in_out == "OUTPUT"
                   for item in tree.interface.items_tree):
            tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    for node in tree.nodes:
        if node.bl_idname == kind:
            return node
    node = tree.nodes.new(kind)
    node.location = (400, 0)
    return node


def strips(editor):
    """All strips of a sequence editor: `sequences` up to 4.3, `strips` since 4.4."""
    return editor.strips if hasattr(editor, "strips") else editor.sequences


def has_strips(scene):
    return scene.sequence_editor is not None and len(strips(scene.sequence_editor)) > 0


def strip_end(strip):
    """The first frame after a strip."""
    return strip.frame_final_end if hasattr(strip, "frame_final_end") else strip.right_handle


def shutter(scene):
    """Opening and closing of the shutter in frames; the position moved from Cycles to the render
    settings in 4.2."""
    if not scene.render.use_motion_blur:
        return (0.0, 0.0)
    owner = scene.render if hasattr(scene.render, "motion_blur_position") else scene.cycles
    length = scene.render.motion_blur_shutter
    begin = {"START": 0.0, "CENTER": -length / 2, "END": -length}[owner.motion_blur_position]
    return (begin, begin + length)


def rolling_shutter(scene):
    """Duration of the exposure of a line as a fraction of the shutter; None without it."""
    if getattr(scene.cycles, "rolling_shutter_type", "NONE") == "NONE":
        return None
    return scene.cycles.rolling_shutter_duration


def panorama(camera):
    """Kind and parameters of a panoramic camera: of Cycles' camera data, and since 5.0 of the
    camera itself."""
    for owner in (camera, getattr(camera, "cycles", None)):
        if owner is not None and hasattr(owner, "panorama_type"):
            names = [p.identifier for p in owner.bl_rna.properties
                     if p.identifier.startswith(("fisheye_", "latitude_", "longitude_",
                                                 "central_cylindrical_"))]
            return owner.panorama_type, {name: getattr(owner, name) for name in names}
    return "", {}


def draw_progress(layout, fraction, text):
    if hasattr(layout, "progress"):  # 4.0
        layout.progress(factor=fraction, text=text)
    else:
        layout.label(text=f"{round(100 * fraction)} %  {text}", icon="SORTTIME")
