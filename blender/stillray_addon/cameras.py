# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Cameras of rendered frames, written beside the frames while Blender renders them."""
import os

import bpy
from bpy.app.handlers import persistent

from . import camera_math, prepare, versions


def file_of(names):
    """shot.####.exr has its cameras in shot.cameras.json."""
    stem = names.prefix.rstrip("._- ") or "frames"
    return os.path.join(names.folder, stem + ".cameras.json")


def picture_size(scene):
    render = scene.render
    return (max(render.resolution_x * render.resolution_percentage // 100, 1),
            max(render.resolution_y * render.resolution_percentage // 100, 1))


def _crop(scene):
    """(border, width, height) of the files."""
    render = scene.render
    width, height = picture_size(scene)
    if not (render.use_border and render.use_crop_to_border):
        return None, width, height
    border = (render.border_min_x, render.border_min_y, render.border_max_x, render.border_max_y)
    return camera_math.border_pixels(border, width, height)


def camera_at(scene, frame):
    markers = [(m.frame, m.camera) for m in scene.timeline_markers]
    return camera_math.marker_camera(markers, frame, scene.camera)


def record(scene, depsgraph, frame):
    """One frame of the file, from an evaluated depsgraph at that frame; None without a camera."""
    camera = camera_at(scene, frame)
    if camera is None or camera.type != "CAMERA":
        return None
    evaluated = camera.evaluated_get(depsgraph)
    data = evaluated.data
    border, _, _ = _crop(scene)
    result = {
        "frame": frame,
        "camera": camera.name,
        "type": {"PERSP": "perspective", "ORTHO": "orthographic", "PANO": "panoramic"}.get(
            data.type, data.type.lower()),
        "world_to_camera": camera_math.flat(camera_math.world_to_camera(evaluated.matrix_world)),
        "projection": None,
        "shutter": list(versions.shutter(scene)),
        "near": data.clip_start,
        "far": data.clip_end,
    }
    if result["type"] in ("perspective", "orthographic"):
        width, height = picture_size(scene)
        projection = evaluated.calc_matrix_camera(
            depsgraph, x=width, y=height, scale_x=scene.render.pixel_aspect_x,
            scale_y=scene.render.pixel_aspect_y)
        projection = [list(row) for row in projection]
        result["projection"] = camera_math.flat(
            camera_math.cropped(projection, border) if border else projection)
    else:
        kind, parameters = versions.panorama(data)
        result["panorama"] = {"kind": kind.lower(), **parameters}
    if scene.render.use_motion_blur and versions.rolling_shutter(scene) is not None:
        result["rolling_shutter"] = versions.rolling_shutter(scene)
    return result


def write(scene, names, records):
    _, width, height = _crop(scene)
    os.makedirs(names.folder, exist_ok=True)
    camera_math.write(file_of(names), width, height, records)


def missing_frames(names, frames):
    """Frames whose camera is not in the file."""
    document = camera_math.read(file_of(names))
    known = {f["frame"] for f in document["frames"]} if document else set()
    return [f for f in frames if f not in known]


def evaluate(context, scene, frame):
    """The record of a frame outside of a render: goes to the frame."""
    scene.frame_set(frame)
    layer = context.view_layer if context.scene == scene else scene.view_layers[0]
    layer.update()
    return record(scene, layer.depsgraph, frame)


class _Recorder:
    """Gathers the cameras of one render, as Blender evaluates them."""

    def __init__(self, scene):
        self.scene_name = scene.name
        self.names = prepare.frame_names(scene)
        self.records = {}
        self.frame = None

    def begin_frame(self, scene):
        self.frame = scene.frame_current

    def frame_changed(self, scene, depsgraph):
        """Blender announces the frame first, then evaluates it; then, for motion blur, the ends
        of the shutter, and for motion vectors the frames before and after it."""
        if depsgraph.mode != "RENDER" or self.frame is None:
            return
        time = scene.frame_current + scene.frame_subframe - self.frame
        if self.frame not in self.records and time == 0:
            new = record(scene, depsgraph, self.frame)
            if new is not None:
                self.records[self.frame] = new
        elif self.frame in self.records and time != 0 and scene.render.use_motion_blur:
            camera = camera_at(scene, self.frame).evaluated_get(depsgraph)
            poses = self.records[self.frame].setdefault("motion", [])
            if all(pose["time"] != round(time, 6) for pose in poses):  # once per view layer
                poses.append({"time": round(time, 6), "world_to_camera": camera_math.flat(
                    camera_math.world_to_camera(camera.matrix_world))})

    def write(self, scene):
        if self.records:
            write(scene, self.names, list(self.records.values()))


_recorder = None


def _failed(error):
    """Cameras are an extra: a render does not stop because of them."""
    global _recorder
    _recorder = None
    print(f"stillray: the cameras are not written: {error}")


@persistent
def _render_init(scene, *_):
    global _recorder
    _recorder = None
    if scene is None or not scene.stillray.prepared or not versions.is_multilayer(scene):
        return  # only of scenes that were prepared
    try:
        _recorder = _Recorder(scene)
    except ValueError as error:
        _failed(error)


@persistent
def _render_pre(scene, *_):
    if _recorder is not None and scene is not None and scene.name == _recorder.scene_name:
        _recorder.begin_frame(scene)


@persistent
def _frame_changed(scene, depsgraph=None, *_):
    if _recorder is None or depsgraph is None or scene.name != _recorder.scene_name:
        return
    try:
        _recorder.frame_changed(scene, depsgraph)
    except (AttributeError, RuntimeError, ValueError) as error:
        _failed(error)


@persistent
def _render_ended(scene, *_):
    global _recorder
    if _recorder is None or scene is None:
        return
    try:
        _recorder.write(scene)
    except (OSError, ValueError) as error:
        _failed(error)
    _recorder = None


_HANDLERS = (("render_init", _render_init), ("render_pre", _render_pre),
             ("frame_change_post", _frame_changed), ("render_complete", _render_ended),
             ("render_cancel", _render_ended))


def register():
    for name, function in _HANDLERS:
        getattr(bpy.app.handlers, name).append(function)


def unregister():
    for name, function in _HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        if function in handlers:
            handlers.remove(function)
