# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Shows denoised frames: image editor, compositor, sequencer."""
import os

import bpy

from . import versions

_ROLES = ("noisy", "denoised")


def image_name(scene, role):
    return f"{scene.name} {role}"


def load_image(scene, role, names, frames):
    """The image data-block of a sequence; loaded again if it exists."""
    file = names.file(frames[0])
    name = image_name(scene, role)
    image = bpy.data.images.get(name)
    if image is None or image.source not in ("SEQUENCE", "FILE"):
        image = bpy.data.images.load(file, check_existing=False)
        image.name = name
    else:
        image.filepath = file
    image.source = "SEQUENCE"
    image.reload()
    return image


def set_range(user, frames):
    """Shows frame N of the sequence at frame N. user: an ImageUser or an Image node."""
    user.frame_start = frames[0]
    user.frame_offset = frames[0] - 1
    user.frame_duration = frames[-1] - frames[0] + 1
    user.use_auto_refresh = True
    user.use_cyclic = False


def image_spaces(context):
    """[(area, space)] of open image editors; those of the current screen come first."""
    windows = list(context.window_manager.windows)
    if context.window in windows:
        windows.remove(context.window)
        windows.insert(0, context.window)
    return [(area, area.spaces.active) for window in windows for area in window.screen.areas
            if area.type == "IMAGE_EDITOR" and area.ui_type == "IMAGE_EDITOR"]


def open_image_space(context):
    """An image editor: an open one, or one in a window of its own. None in background mode."""
    spaces = image_spaces(context)
    if spaces:
        return spaces[0]
    if bpy.app.background or context.window is None:
        return None
    bpy.ops.wm.window_new()
    area = context.window_manager.windows[-1].screen.areas[0]
    area.type = "IMAGE_EDITOR"
    area.ui_type = "IMAGE_EDITOR"
    return area, area.spaces.active


def show(context, image, frames):
    """Returns False if there is no window."""
    place = open_image_space(context)
    if place is None:
        return False
    area, space = place
    space.image = image
    set_range(space.image_user, frames)
    area.tag_redraw()
    return True


def toggle(context, scene, images, frames):
    """Swaps noisy and denoised in every image editor that shows one of them; in the first one if
    none does. Returns the role that is now shown, or "" if there is no image editor."""
    by_role = dict(zip(_ROLES, images))
    showing = [(area, space) for area, space in image_spaces(context) if space.image in images]
    if not showing:
        return "denoised" if show(context, by_role["denoised"], frames) else ""
    role = "noisy" if showing[0][1].image == by_role["denoised"] else "denoised"
    for area, space in showing:
        space.image = by_role[role]
        set_range(space.image_user, frames)
        area.tag_redraw()
    return role


def _layer_node(tree, image, layer, frames):
    """An Image node of one view layer; the one of an earlier call is used again."""
    label = f"{image.name}: {layer}" if layer else image.name
    node = next((n for n in tree.nodes
                 if n.bl_idname == "CompositorNodeImage" and n.label == label), None)
    if node is None:
        node = tree.nodes.new("CompositorNodeImage")
        node.label = label
    node.image = image
    set_range(node, frames)
    if layer and getattr(node, "has_layers", False):
        try:
            node.layer = layer
        except TypeError:
            pass  # the file has no such layer
    return node


def _output_named(node, name):
    """The output of an Image node that matches one of Render Layers."""
    names = ("Combined", "Image") if name in ("Image", "Noisy Image") else (name,)
    return next((node.outputs[n] for n in names if n in node.outputs), None)


def to_compositor(scene, image, frames):
    """Denoised frames take the place of Render Layers: every link moves to the same pass of an
    Image node, and Render Layers is muted, so that nothing is rendered again. Returns the number of
    links."""
    tree = versions.ensure_compositor_tree(scene)
    sources = [n for n in tree.nodes if n.bl_idname == "CompositorNodeRLayers"
               and n.scene in (scene, None)]
    moved = 0
    for source in sources:
        node = _layer_node(tree, image, source.layer, frames)
        node.location = (source.location[0], source.location[1] - 420)
        for link in [link for link in tree.links if link.from_node == source]:
            output = _output_named(node, link.from_socket.name)
            if output is not None:
                tree.links.new(output, link.to_socket)
                moved += 1
        source.mute = not any(link.from_node == source for link in tree.links)
    target = versions.compositor_output(tree).inputs[0]
    if not target.is_linked:
        node = _layer_node(tree, image, "", frames) if not sources else \
            _layer_node(tree, image, sources[0].layer, frames)
        tree.links.new(_output_named(node, "Image") or node.outputs[0], target)
        moved += 1
    scene.render.use_compositing = True
    return moved


def to_sequencer(scene, names, frames):
    """A strip of the denoised frames on a free channel; one of the same name is replaced."""
    if scene.sequence_editor is None:
        scene.sequence_editor_create()
    strips = versions.strips(scene.sequence_editor)
    name = image_name(scene, "denoised")
    for strip in [s for s in strips if s.name == name]:
        strips.remove(strip)
    channel = max((s.channel for s in strips), default=0) + 1
    strip = strips.new_image(name=name, filepath=names.file(frames[0]), channel=channel,
                             frame_start=frames[0])
    for frame in range(frames[0] + 1, frames[-1] + 1):
        strip.elements.append(os.path.basename(names.file(frame)))
    return strip
