# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Operators: prepare, restore, render, denoise, check, show."""
import os
import shutil
import threading
import time

import bpy
from bpy.props import BoolProperty, StringProperty

from . import (camera_math, cameras, command, exr_header, flatten, job, lock, paths, prepare,
               program, progress, properties, results, settings)

_TICK_SECONDS = 0.2


class UserError(RuntimeError):
    """Shown as a report of Blender."""


_ERRORS = (UserError, job.JobError, lock.Locked, program.ProgramError, ValueError, OSError)


class _Active:
    """What runs now, for the panel and for Cancel. One at a time in one Blender."""

    def __init__(self, text):
        self.text = text
        self.fraction = 0.0
        self.renders = False
        self.cancel = threading.Event()


active = None


# ------------------------------------------------------------------------- inputs of a run

def find_program(context):
    preferences = properties.preferences(context)
    return program.find(preferences.program if preferences else "", os.environ,
                        os.path.dirname(os.path.abspath(__file__)))


def program_text(context):
    """(text, icon) for the preferences and the panel."""
    try:
        found = find_program(context)
        return f"stillray {'.'.join(map(str, found.version))}: {found.path}", "CHECKMARK"
    except program.ProgramError as error:
        return str(error), "ERROR"


def result_names(scene):
    names = prepare.frame_names(scene)
    return names.moved(paths.result_folder(names.folder, bpy.path.abspath(scene.stillray.folder)
                                           if scene.stillray.folder.startswith("//")
                                           else scene.stillray.folder))


def rendered_frames(scene):
    """(names, numbers of the scene's frames that exist). Raises UserError if there are none."""
    names = prepare.frame_names(scene)
    frames = names.present(scene.frame_start, scene.frame_end)
    if not frames:
        raise UserError(f"There are no rendered frames {scene.frame_start}-{scene.frame_end}: no "
                        f"{names.pattern} in {names.folder}. Render first")
    return names, frames


def _check_files(names, frames):
    damaged = job.damaged(names, frames)
    if damaged:
        numbers = paths.ranges(frame for frame, _ in damaged)
        raise UserError(f"Frame {numbers} cannot be used: {damaged[0][1]}. Render it again with "
                        "Render Missing Frames")


def view_layers(scene, active_layer, names, frames):
    """View layers to denoise, by what the files hold; [""] leaves the choice to the program."""
    found = exr_header.read(names.file(frames[0])).view_layers
    if len(found) < 2:
        return [""]
    if scene.stillray.all_layers:
        return found
    if active_layer not in found:
        raise UserError(f"The frames do not have the view layer {active_layer}; they have "
                        f"{', '.join(found)}")
    return [active_layer]


def options_of(scene, names, frames, found):
    """Settings of the panel as plain data. Cameras are given to a program that takes them."""
    values = scene.stillray
    file = cameras.file_of(names)
    use_cameras = found.has("--cameras") and camera_math.can_be_used(file, names, frames)
    return command.Options(
        preset=values.preset, window=values.window, passes=values.passes,
        fireflies=values.fireflies, smooth=values.smooth, device=values.device, threads=values.threads,
        memory_limit=values.memory_limit,
        aovs=[text.strip() for text in values.aovs.split(";") if text.strip()],
        cameras=file if use_cameras else "")


def _free_space_warning(names, frames, folder, stages):
    needed = sum(os.path.getsize(names.file(f)) for f in frames) * stages
    while folder and not os.path.isdir(folder):
        folder = os.path.dirname(folder)
    try:
        free = shutil.disk_usage(folder).free
    except OSError:
        return ""
    if free >= needed:
        return ""
    return (f"{folder} has {free / 1e9:.1f} GB left; the denoised frames need about "
            f"{needed / 1e9:.1f} GB")


def _missing_finding(frames):
    """The program examines the first frames alone while it denoises."""
    missing = sorted(set(range(frames[0], frames[-1] + 1)) - set(frames))
    if not missing:
        return []
    return [{"name": "frames_missing", "aov": "", "frames": missing,
             "what": f"Frames {paths.ranges(missing)} are missing: noise is gathered anew after "
                     "them",
             "cure": "render the missing frames"}]


def denoise_job(context, scene, again=False):
    """The job for all rendered frames, and warnings to report."""
    found = find_program(context)
    names, frames = rendered_frames(scene)
    _check_files(names, frames)
    layers = view_layers(scene, context.view_layer.name, names, frames)
    result = result_names(scene).folder
    stages = job.plan_denoise(found, names, frames, result, layers,
                              options_of(scene, names, frames, found))
    notes = [_free_space_warning(names, frames, result, len(stages))]
    work = os.path.join(result, job.WORK)
    return (job.Job(found, stages, work, job.fingerprint(names, frames), resume=not again),
            [note for note in notes if note])


def frame_job(context, scene, frame):
    found = find_program(context)
    names, frames = rendered_frames(scene)
    near = paths.contiguous_around(frames, frame, scene.stillray.neighbours)
    if not near:
        raise UserError(f"Frame {frame} is not rendered; rendered are {paths.ranges(frames)}")
    _check_files(names, near)
    layers = view_layers(scene, context.view_layer.name, names, near)
    work = os.path.join(result_names(scene).folder, job.WORK, "frame")
    options = options_of(scene, names, near, found)
    stages = job.plan_denoise(found, names, near, os.path.join(work, "out"), layers, options, work)
    return job.Job(found, stages, work, resume=False)


def check_job(context, scene):
    found = find_program(context)
    names, frames = rendered_frames(scene)
    _check_files(names, frames)
    layers = view_layers(scene, context.view_layer.name, names, frames)
    work = os.path.join(result_names(scene).folder, job.WORK, "check")
    stages = job.plan_check(names, frames, options_of(scene, names, frames, found), work, layers[0])
    return job.Job(found, stages, work, resume=False)


# ------------------------------------------------------------------------- runs

def _redraw(context):
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()


class _Run:
    """An operator that runs a job: at once in background mode or from a script, modal otherwise.

    Blender may replace all its data by undo while a modal operator runs: only names are kept.
    """

    _job = None
    _timer = None
    _scene_name = ""
    _began = 0.0

    # To be written by operators.
    def make_job(self, context, scene):
        raise NotImplementedError

    def finished(self, context, scene):
        raise NotImplementedError

    def scene(self):
        scene = bpy.data.scenes.get(self._scene_name)
        if scene is None:
            raise UserError(f"The scene {self._scene_name} is gone")
        return scene

    def _begin(self, context):
        global active
        if active is not None:
            raise UserError("stillray is at work already: wait, or cancel it first")
        self._scene_name = context.scene.name
        self._began = time.monotonic()
        active = _Active(self.bl_label)

    def _end(self, context):
        global active
        active = None
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None
        if not bpy.app.background:
            for workspace in bpy.data.workspaces:
                workspace.status_text_set(None)
            context.window_manager.progress_end()
            _redraw(context)

    def _start_job(self, context):
        self._job = self.make_job(context, self.scene())
        self._job.start()

    def _conclude(self, context):
        if self._job.state == "finished":
            self.finished(context, self.scene())
            return {"FINISHED"}
        if self._job.state == "cancelled":
            self.report({"WARNING"}, "Stopped. Denoise again to go on where it stopped")
        else:
            self.report({"ERROR"}, self._job.error)
        return {"CANCELLED"}

    def execute(self, context):
        try:
            self._begin(context)
        except _ERRORS as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        try:
            self.before_sync(context)
            self._start_job(context)
            self._wait()
            return self._conclude(context)
        except _ERRORS as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            self._end(context)

    def before_sync(self, context):
        pass

    def _wait(self):
        shown = ""
        try:
            while self._job.poll() == "running":
                if active.cancel.is_set():
                    self._job.cancel()
                if bpy.app.background and self._job.status() != shown:
                    shown = self._job.status()
                    print(f"stillray: {shown}", flush=True)
                time.sleep(0.05)
        except KeyboardInterrupt:
            self._job.cancel()
            self._job.wait()

    def invoke(self, context, event):
        if bpy.app.background:
            return self.execute(context)
        try:
            self._begin(context)
        except _ERRORS as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        try:
            self.begin_modal(context)
        except _ERRORS as error:
            self.report({"ERROR"}, str(error))
            self._end(context)
            return {"CANCELLED"}
        manager = context.window_manager
        self._timer = manager.event_timer_add(_TICK_SECONDS, window=context.window)
        manager.progress_begin(0, 100)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def begin_modal(self, context):
        self._start_job(context)

    def modal(self, context, event):
        if event.type == "ESC" and event.value == "PRESS" and self._job is not None:
            active.cancel.set()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        try:
            done = self.tick(context)
        except _ERRORS as error:
            self.report({"ERROR"}, str(error))
            done = {"CANCELLED"}
        except Exception:
            self.cancel(context)  # a defect of the add-on must not block the next run
            raise
        if done:
            self._end(context)
            return done
        return {"PASS_THROUGH"}

    def tick(self, context):
        """A step of a modal run; returns the operator's result at the end."""
        if active.cancel.is_set():
            self._job.cancel()
        if self._job.poll() != "running":
            return self._conclude(context)
        self._show(context, self._job.status(), self._job.fraction)
        return None

    def _show(self, context, text, fraction, keys="[Esc: cancel]"):
        if (active.text, active.fraction) == (text, fraction):
            return
        active.text, active.fraction = text, fraction
        context.workspace.status_text_set(f"stillray   {round(100 * fraction)} %   {text}   {keys}")
        context.window_manager.progress_update(round(100 * fraction))
        _redraw(context)

    def cancel(self, context):
        """Blender loads another file or quits: the program finishes its work by itself."""
        if self._job is not None:
            self._job.detach()
        self._end(context)


class _SceneOperator:
    @classmethod
    def poll(cls, context):
        return context.scene is not None


class STILLRAY_OT_denoise(_SceneOperator, _Run, bpy.types.Operator):
    """Denoise the rendered frames of this scene. Continues where a stopped run ended"""
    bl_idname = "stillray.denoise"
    bl_label = "Denoise Rendered Frames"

    again: BoolProperty(name="Again", default=False, options={"SKIP_SAVE"},
                        description="Also if nothing has changed since the last time")

    def make_job(self, context, scene):
        made, notes = denoise_job(context, scene, self.again)
        for note in notes:
            self.report({"WARNING"}, note)
        return made

    def finished(self, context, scene):
        done = self._job
        frames = len(done.stages[0].frames)
        found = _missing_finding(done.stages[0].frames)
        found += job.findings_of(done.stages[0].json_file)
        scene.stillray.set_findings(found, paths.ranges)
        folder = done.stages[-1].output
        if done.reused == len(done.stages):
            self.report({"INFO"}, f"The {frames} frames are denoised already, in {folder}")
            return
        seconds = progress.duration(time.monotonic() - self._began)
        self.report({"INFO"}, f"Denoised {frames} frames in {seconds}: {folder}")
        if found:
            self.report({"WARNING"}, f"{len(found)} findings in the rendered frames: "
                        f"{found[0]['what']}")
        if not bpy.app.background and results.image_spaces(context):
            names = result_names(scene)
            image = results.load_image(scene, "denoised", names, done.stages[-1].frames)
            results.show(context, image, done.stages[-1].frames)


class STILLRAY_OT_render(_SceneOperator, _Run, bpy.types.Operator):
    """Render the animation with few samples, then denoise it"""
    bl_idname = "stillray.render"
    bl_label = "Render and Denoise"

    missing_only: BoolProperty(
        name="Missing Frames Only", default=False, options={"SKIP_SAVE"},
        description="Render frames only whose files are missing or damaged")

    _rendering = ""  # "", "running", "complete", "cancelled"
    _kept = None

    make_job = STILLRAY_OT_denoise.make_job
    finished = STILLRAY_OT_denoise.finished
    again = False

    def _before_render(self, context):
        scene = self.scene()
        find_program(context)  # before hours of rendering, not after
        blocking = [w.text for w in prepare.warnings(scene) if w.blocks]
        if blocking:
            raise UserError(f"{'. '.join(blocking)}. Press Prepare first")
        names = prepare.frame_names(scene)
        if self.missing_only:
            for frame, _ in job.damaged(names, names.present(scene.frame_start, scene.frame_end)):
                os.remove(names.file(frame))
        # The noisy frames must come from Cycles alone; the compositor follows after denoising.
        wanted = {"use_compositing": False, "use_sequencer": False,
                  "use_overwrite": not self.missing_only, "use_placeholder": False}
        self._kept = {name: getattr(scene.render, name) for name in wanted}
        for name, value in wanted.items():
            setattr(scene.render, name, value)

    def _after_render(self):
        if self._kept is not None:
            scene = bpy.data.scenes.get(self._scene_name)
            for name, value in self._kept.items() if scene is not None else ():
                setattr(scene.render, name, value)
            self._kept = None

    def before_sync(self, context):
        self._before_render(context)
        try:
            bpy.ops.render.render(animation=True, scene=self._scene_name)
        except RuntimeError as error:
            raise UserError(str(error).removeprefix("Error: ").strip()) from error
        finally:
            self._after_render()
        self._check_rendered()

    def _check_rendered(self):
        """Blender reports a full disk or a folder that it cannot write to, and goes on."""
        scene = self.scene()
        names, frames = rendered_frames(scene)
        missing = sorted(set(range(scene.frame_start, scene.frame_end + 1, scene.frame_step))
                         - set(frames))
        if missing:
            raise UserError(f"Frames {paths.ranges(missing)} were not written to {names.folder}")

    def begin_modal(self, context):
        self._before_render(context)
        self._rendering = "running"
        self._handlers = {"render_complete": self._on_complete, "render_cancel": self._on_cancel}
        for name, function in self._handlers.items():
            getattr(bpy.app.handlers, name).append(function)
        active.renders = True
        try:
            started = bpy.ops.render.render("INVOKE_DEFAULT", animation=True,
                                            scene=self._scene_name)
        except RuntimeError as error:
            self._leave_render()
            raise UserError(str(error).removeprefix("Error: ").strip()) from error
        if started == {"CANCELLED"}:
            self._leave_render()
            raise UserError("Blender does not render: is another render under way?")

    def _on_complete(self, *_):
        self._rendering = "complete"

    def _on_cancel(self, *_):
        self._rendering = "cancelled"

    def _leave_render(self):
        for name, function in getattr(self, "_handlers", {}).items():
            handlers = getattr(bpy.app.handlers, name)
            if function in handlers:
                handlers.remove(function)
        self._handlers = {}
        self._rendering = ""
        self._after_render()
        if active is not None:
            active.renders = False

    def tick(self, context):
        if self._rendering == "running":
            scene = self.scene()
            total = max(scene.frame_end - scene.frame_start, 0) + 1
            done = min(max(scene.frame_current - scene.frame_start, 0), total)
            text = f"Rendering frame {scene.frame_current} ({done} of {total} are done)"
            elapsed = time.monotonic() - self._began
            if done > 0:
                text += f", {progress.duration(elapsed * (total - done) / done)} left"
            self._show(context, text, done / total, "[Esc in the render window: stop]")
            return None
        if self._job is None:
            state = self._rendering
            self._leave_render()
            if state == "cancelled" or active.cancel.is_set():
                self.report({"WARNING"}, "Rendering was stopped. Render Missing Frames goes on")
                return {"CANCELLED"}
            self._check_rendered()
            self._start_job(context)
            return None
        return _Run.tick(self, context)

    def cancel(self, context):
        self._leave_render()
        _Run.cancel(self, context)


class STILLRAY_OT_denoise_frame(_SceneOperator, _Run, bpy.types.Operator):
    """Denoise the current frame with light of the rendered frames around it, as a test"""
    bl_idname = "stillray.denoise_frame"
    bl_label = "Denoise This Frame"

    def make_job(self, context, scene):
        self._frame = scene.frame_current
        return frame_job(context, scene, self._frame)

    def finished(self, context, scene):
        stage = self._job.stages[-1]
        target = result_names(scene).moved(os.path.join(result_names(scene).folder, "single"))
        os.makedirs(target.folder, exist_ok=True)
        os.replace(stage.names.file(self._frame), target.file(self._frame))
        shutil.rmtree(stage.output, ignore_errors=True)
        scene.stillray.set_findings(job.findings_of(self._job.stages[0].json_file), paths.ranges)
        self.report({"INFO"}, f"Denoised frame {self._frame} with {len(stage.frames) - 1} "
                    f"neighbours: {target.file(self._frame)}")
        if not bpy.app.background:
            image = results.load_image(scene, "single", target, [self._frame])
            results.show(context, image, [self._frame])


class STILLRAY_OT_check(_SceneOperator, _Run, bpy.types.Operator):
    """Examine the rendered frames for faults that spoil denoising, and say what cures them"""
    bl_idname = "stillray.check"
    bl_label = "Check Rendered Frames"

    make_job = staticmethod(check_job)

    def finished(self, context, scene):
        found = job.findings_of(self._job.stages[-1].json_file)
        scene.stillray.set_findings(found, paths.ranges)
        frames = len(self._job.stages[-1].frames)
        if not found:
            self.report({"INFO"}, f"Nothing wrong was found in {frames} frames")
            return
        for finding in found:
            self.report({"WARNING"}, finding["what"])


class STILLRAY_OT_cancel(bpy.types.Operator):
    """Stop denoising. Finished frames stay, and the next run goes on from there"""
    bl_idname = "stillray.cancel"
    bl_label = "Cancel"

    def execute(self, context):
        if active is None:
            self.report({"WARNING"}, "stillray is not at work")
            return {"CANCELLED"}
        active.cancel.set()
        if active.renders:
            self.report({"INFO"}, "Press Esc in the render window to stop the rendering as well")
        return {"FINISHED"}


# ------------------------------------------------------------------------- settings

def _report_changes(operator, changes, verb):
    for change in changes:
        operator.report({"INFO"}, change.text())
    operator.report({"INFO"}, f"{verb} {len(changes)} settings")


class STILLRAY_OT_prepare(_SceneOperator, bpy.types.Operator):
    """Set passes, samples, seed and output so that the frames can be denoised. Restore undoes it"""
    bl_idname = "stillray.prepare"
    bl_label = "Prepare"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        scene = context.scene
        try:
            changes, failed = prepare.change(scene, prepare.wanted(scene))
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        scene.stillray.prepared = True
        if failed:
            self.report({"ERROR"}, f"Blender does not take these settings: {', '.join(failed)}")
        _report_changes(self, changes, "Prepare changed")
        if scene.render.filepath.startswith("//") and not bpy.data.filepath:
            self.report({"WARNING"}, "Save the file before rendering: frames go beside it")
        for warning in prepare.warnings(scene):
            self.report({"WARNING"}, warning.text)
        return {"FINISHED"}


class STILLRAY_OT_restore(_SceneOperator, bpy.types.Operator):
    """Bring back every setting that Prepare and the cures changed"""
    bl_idname = "stillray.restore"
    bl_label = "Restore"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.scene is not None and bool(context.scene.stillray.saved)

    def execute(self, context):
        undone, left = prepare.restore(context.scene)
        for change in left:
            self.report({"WARNING"}, f"Left as it is, since it was changed after Prepare: "
                        f"{change.text().split(':')[0]}")
        self.report({"INFO"}, f"Restored {len(undone)} settings")
        return {"FINISHED"}


class STILLRAY_OT_cure(_SceneOperator, bpy.types.Operator):
    """Change the settings that cause this"""
    bl_idname = "stillray.cure"
    bl_label = "Cure"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(options={"SKIP_SAVE"})

    @classmethod
    def description(cls, context, operator_properties):
        cure = prepare.CURES.get(operator_properties.name)
        return cure[0] if cure else cls.__doc__

    def execute(self, context):
        scene = context.scene
        finding = next((f for f in scene.stillray.findings if f.name == self.name), None)
        if finding is not None and finding.aov:
            values = [v for v in scene.stillray.aovs.split(";") if v.strip()]
            if finding.aov not in values:
                scene.stillray.aovs = "; ".join([*values, finding.aov])
            self.report({"INFO"}, f"Layers will be read with {finding.aov}. Denoise again")
            return {"FINISHED"}
        if self.name not in prepare.CURES:
            self.report({"ERROR"}, f"There is no setting that cures '{self.name}'")
            return {"CANCELLED"}
        changes, failed = prepare.change(scene, prepare.CURES[self.name][1](scene))
        if failed:
            self.report({"ERROR"}, f"Blender does not take these settings: {', '.join(failed)}")
        _report_changes(self, changes, "Changed")
        if finding is not None and self.name not in prepare.WITHOUT_RENDERING:
            self.report({"INFO"}, "Render the frames again")
        return {"FINISHED"}


# ------------------------------------------------------------------------- results

def denoised_frames(scene):
    names = result_names(scene)
    frames = names.present(scene.frame_start, scene.frame_end)
    if not frames:
        raise UserError(f"There are no denoised frames in {names.folder}. Denoise first")
    return names, frames


class _ResultOperator(_SceneOperator):
    """An operator on denoised frames."""

    def execute(self, context):
        try:
            return self.use(context, context.scene)
        except _ERRORS as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}


class STILLRAY_OT_show(_ResultOperator, bpy.types.Operator):
    """Load the denoised frames, and show them in an image editor"""
    bl_idname = "stillray.show"
    bl_label = "Show"

    def use(self, context, scene):
        names, frames = denoised_frames(scene)
        image = results.load_image(scene, "denoised", names, frames)
        if not results.show(context, image, frames):
            self.report({"INFO"}, f"Loaded as image {image.name}")
        return {"FINISHED"}


class STILLRAY_OT_toggle(_ResultOperator, bpy.types.Operator):
    """Swap noisy and denoised frames in the image editor"""
    bl_idname = "stillray.toggle"
    bl_label = "Before / After"

    def use(self, context, scene):
        names, frames = denoised_frames(scene)
        noisy_names = prepare.frame_names(scene)
        noisy_frames = noisy_names.present(frames[0], frames[-1])
        if not noisy_frames:
            raise UserError(f"The noisy frames are gone from {noisy_names.folder}")
        images = (self._image(scene, "noisy", noisy_names, noisy_frames),
                  self._image(scene, "denoised", names, frames))
        shown = results.toggle(context, scene, images, frames)
        self.report({"INFO"}, f"Now shown: {shown}" if shown else "There is no image editor")
        return {"FINISHED"}

    @staticmethod
    def _image(scene, role, names, frames):
        """Loaded once: swapping must be instant."""
        image = bpy.data.images.get(results.image_name(scene, role))
        if image is not None and os.path.normpath(bpy.path.abspath(image.filepath)) == \
                os.path.normpath(names.file(frames[0])):
            return image
        return results.load_image(scene, role, names, frames)


class STILLRAY_OT_to_compositor(_ResultOperator, bpy.types.Operator):
    """Put the denoised frames in the place of Render Layers in the compositor"""
    bl_idname = "stillray.to_compositor"
    bl_label = "Use in Compositor"
    bl_options = {"REGISTER", "UNDO"}

    def use(self, context, scene):
        names, frames = denoised_frames(scene)
        image = results.load_image(scene, "denoised", names, frames)
        links = results.to_compositor(scene, image, frames)
        self.report({"INFO"}, f"{links} links of the compositor now come from the denoised frames")
        return {"FINISHED"}


class STILLRAY_OT_to_sequencer(_SceneOperator, _Run, bpy.types.Operator):
    """Add the denoised frames as a strip of the sequencer. The sequencer reads no multilayer files:
    copies with the picture alone are written beside them"""
    bl_idname = "stillray.to_sequencer"
    bl_label = "Add to Sequencer"
    bl_options = {"REGISTER", "UNDO"}

    def make_job(self, context, scene):
        names, frames = denoised_frames(scene)
        layers = exr_header.read(names.file(frames[0])).view_layers
        layer = context.view_layer.name if context.view_layer.name in layers else ""
        return flatten.FlattenJob(names, frames, names.moved(os.path.join(names.folder, "plain")),
                                  layer)

    def finished(self, context, scene):
        strip = results.to_sequencer(scene, self._job.target, self._job.frames)
        self.report({"INFO"}, f"Strip '{strip.name}' is on channel {strip.channel}")


class STILLRAY_OT_write_cameras(_SceneOperator, bpy.types.Operator):
    """Write the camera of every frame beside the frames. Render and Denoise does it anyway"""
    bl_idname = "stillray.write_cameras"
    bl_label = "Write Cameras"

    def execute(self, context):
        scene = context.scene
        current = scene.frame_current
        try:
            names = prepare.frame_names(scene)
            records = [cameras.evaluate(context, scene, frame)
                       for frame in range(scene.frame_start, scene.frame_end + 1)]
            if None in records:
                raise UserError("The scene has no camera")
            cameras.write(scene, names, records)
        except _ERRORS as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            scene.frame_set(current)
        self.report({"INFO"}, f"{len(records)} cameras: {cameras.file_of(names)}")
        return {"FINISHED"}


CLASSES = (STILLRAY_OT_denoise, STILLRAY_OT_render, STILLRAY_OT_denoise_frame, STILLRAY_OT_check,
           STILLRAY_OT_cancel, STILLRAY_OT_prepare, STILLRAY_OT_restore, STILLRAY_OT_cure,
           STILLRAY_OT_show, STILLRAY_OT_toggle, STILLRAY_OT_to_compositor,
           STILLRAY_OT_to_sequencer, STILLRAY_OT_write_cameras)


def saved_changes(scene):
    return settings.load(scene.stillray.saved)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
