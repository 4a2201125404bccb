# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Tests of the add-on in Blender's window: modal operators, panels, undo, Esc.

    xvfb-run blender --factory-startup --enable-event-simulate --python window_test.py -- \
        ADDON.zip STILLRAY FOLDER [keyboard]

With `keyboard`, and without --enable-event-simulate, which disables real keys: only the test that
presses one by xdotool, as Blender's renderer listens to the keyboard alone.

A timer runs one generator; each `yield SECONDS` lets Blender handle its events.
"""
import os
import pathlib
import subprocess
import sys
import time
import traceback

import bpy

ARGUMENTS = sys.argv[sys.argv.index("--") + 1:]
ADDON, PROGRAM, FOLDER = ARGUMENTS[:3]
FAKE = str(pathlib.Path(__file__).with_name("fake_stillray.py"))
LAST = 12
TIMEOUT_SECONDS = 60
draw_errors = []


def check(condition, text):
    if not condition:
        raise AssertionError(text)


def window():
    return bpy.context.window_manager.windows[0]


def override(kind="PROPERTIES"):
    area = next(a for a in window().screen.areas if a.type == kind)
    region = next(r for r in area.regions if r.type == "WINDOW")
    return bpy.context.temp_override(window=window(), area=area, region=region)


def call(name, **named):
    """As a button does, with a step of undo."""
    with override():
        return getattr(bpy.ops.stillray, name)("INVOKE_DEFAULT", True, **named)


def active():
    return sys.modules["stillray_addon.operators"].active


def until_idle(seen):
    """Waits for the end of a modal operator; adds its (text, fraction) to seen."""
    begin = time.monotonic()
    while active() is not None:
        check(time.monotonic() - begin < TIMEOUT_SECONDS, f"still at work: {active().text}")
        if not seen or seen[-1] != (active().text, active().fraction):
            seen.append((active().text, active().fraction))
        yield 0.05


def until(condition, text):
    begin = time.monotonic()
    while not condition():
        check(time.monotonic() - begin < TIMEOUT_SECONDS, text)
        yield 0.05


def watch_panels():
    """Errors of draw() reach only the console. (A replaced draw() would crash Blender 3.4.)"""
    def hook(kind, error, trace):
        draw_errors.append("".join(traceback.format_exception(kind, error, trace)))
    sys.excepthook = hook


def make_scene():
    scene = bpy.context.scene
    camera = scene.camera
    camera.keyframe_insert("location", frame=0)
    camera.location.x += 1
    camera.keyframe_insert("location", frame=LAST + 1)
    scene.frame_start, scene.frame_end = 1, LAST
    scene.render.resolution_x, scene.render.resolution_y = 384, 216  # slow enough to be seen
    scene.render.resolution_percentage = 100
    scene.stillray.samples = 4
    os.makedirs(FOLDER, exist_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=os.path.join(FOLDER, "my shot.blend"))


def test_undo_of_prepare():
    scene = bpy.context.scene
    with override():
        bpy.ops.ed.undo_push(message="before")
    yield 0.3
    check(call("prepare") == {"FINISHED"}, "prepare")
    check(scene.render.engine == "CYCLES" and scene.stillray.saved, "prepared")
    yield 0.3
    with override():
        bpy.ops.ed.undo()
    yield 0.3
    scene = bpy.context.scene  # undo replaces data
    check(scene.render.engine != "CYCLES" and not scene.stillray.saved, "undone")
    check(call("prepare") == {"FINISHED"}, "prepare again")
    yield 0.3


def test_render_and_denoise():
    seen = []
    check(call("render") == {"RUNNING_MODAL"}, "render starts")
    yield from until_idle(seen)
    texts = [text for text, _ in seen]
    check(any(t.startswith("Rendering frame") for t in texts), f"rendering is shown: {texts}")
    check(any(t.startswith("Denoising") for t in texts), f"denoising is shown: {texts}")
    clean = os.path.join(FOLDER, "render", "denoised")
    files = [n for n in os.listdir(clean) if n.endswith(".exr")]
    check(len(files) == LAST, f"{files}")


def press_escape():
    for value in ("PRESS", "RELEASE"):
        window().event_simulate(type="ESC", value=value, x=300, y=300)


def test_keyboard_stops_rendering():
    scene = bpy.context.scene
    check(call("prepare") == {"FINISHED"}, "prepare")
    scene.render.filepath, scene.frame_end = "//render/stopped.####", 60
    scene.render.use_compositing = True
    check(call("render") == {"RUNNING_MODAL"}, "render starts")
    yield from until(lambda: active().text.startswith("Rendering frame"), "rendering is shown")
    check(not scene.render.use_compositing, "the compositor is left out")
    subprocess.run(["xdotool", "mousemove", "100", "100", "key", "Escape"], check=True)
    yield from until_idle([])
    check(scene.render.use_compositing and scene.render.use_overwrite, "settings are as before")
    names = os.listdir(os.path.join(FOLDER, "render"))
    check(len([n for n in names if n.startswith("stopped")]) < 60, "rendering has stopped")
    check("denoised" not in names, "nothing is denoised")


def use_fake(mode):
    os.environ["STILLRAY"], os.environ["FAKE_STILLRAY"] = FAKE, mode


def test_window_stays_alive_while_the_program_runs():
    """The stand-in takes seconds per frame; timers of Blender go on meanwhile."""
    scene = bpy.context.scene
    scene.render.filepath, scene.frame_end = "//render/f.####", 3
    scene.render.resolution_percentage = 25
    os.environ["STILLRAY"] = PROGRAM
    check(call("render") == {"RUNNING_MODAL"}, "render starts")
    yield from until_idle([])
    use_fake("slow")
    check(call("denoise", again=True) == {"RUNNING_MODAL"}, "denoise starts")
    longest, before, begin = 0, time.monotonic(), time.monotonic()
    while time.monotonic() - begin < 3:
        yield 0.05
        longest = max(longest, time.monotonic() - before)
        before = time.monotonic()
    # A run that blocks would take 20 s; software drawing on a busy machine takes up to 1 s.
    check(longest < 5, f"a step of the window took {longest} s")
    check(active() is not None and active().fraction > 0, "frames are counted")


def test_esc_stops():
    """Continues the run of the test before."""
    check(active() is not None, "runs")
    press_escape()
    yield from until_idle([])
    work = os.path.join(FOLDER, "render", "denoised", ".stillray")
    check(not os.path.exists(os.path.join(work, "lock")), "the lock is gone")
    check(os.path.exists(os.path.join(FOLDER, "render", "denoised", "resume.stillray")), "a state")


def test_button_stops():
    check(call("denoise") == {"RUNNING_MODAL"}, "denoise starts")
    yield 0.5
    try:
        call("denoise")
        check(False, "a second run")
    except RuntimeError as error:
        check("at work already" in str(error), str(error))
    check(call("cancel") == {"FINISHED"}, "cancel")
    yield from until_idle([])


def test_another_file_is_opened():
    """The program finishes by itself, and the next run finds its work."""
    os.environ["FAKE_STILLRAY"] = "ok"
    check(call("denoise", again=True) == {"RUNNING_MODAL"}, "denoise starts")
    file = bpy.data.filepath
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.open_mainfile(filepath=file)
    yield 0.5
    check(active() is None, "the operator has ended")
    lock = os.path.join(FOLDER, "render", "denoised", ".stillray", "lock")
    from stillray_addon.lock import Lock
    held = Lock(lock)
    # The lock names this Blender, which lives; it must not block the next run for ever.
    yield from until(lambda: held.holder() is None, "the lock is free")
    for area in window().screen.areas:
        if area.type == "PROPERTIES":
            area.spaces.active.context = "RENDER"
    check(call("denoise") == {"RUNNING_MODAL"} or active() is None, "denoise again")
    yield from until_idle([])


def test_before_and_after():
    scene = bpy.context.scene
    os.environ["STILLRAY"] = PROGRAM
    scene.render.filepath, scene.frame_end = "//render/my shot.####", LAST
    for area in window().screen.areas:
        if area.type == "VIEW_3D":
            area.type = "IMAGE_EDITOR"
            space = area.spaces.active
    yield 0.3
    check(call("show") == {"FINISHED"}, "show")
    yield 0.3
    check(space.image and space.image.name == "Scene denoised", "denoised is shown")
    check(space.image_user.frame_duration == LAST, "all frames")
    scene.frame_set(5)
    yield 0.3
    check(space.image_user.frame_current == 5, f"frame {space.image_user.frame_current}")
    for name in ("Scene noisy", "Scene denoised"):
        check(call("toggle") == {"FINISHED"}, "toggle")
        check(space.image.name == name, f"{name} is shown")
        yield 0.3
    scene.frame_set(4)
    check(call("denoise_frame") == {"RUNNING_MODAL"}, "one frame")
    yield from until_idle([])
    check(space.image.name == "Scene single", "the frame is shown")


def test_panels():
    for text in ("findings", "changes"):
        scene = bpy.context.scene
        if text == "findings":
            for name in ("frames_missing", "fixed_seed", "motion_wrong"):
                finding = scene.stillray.findings.add()
                finding.name, finding.what, finding.cure = name, "What is wrong " * 12, "cure"
            scene.stillray.findings_known = True
        scene.stillray.show_changes = True
        scene.render.use_motion_blur = True
        window().screen.areas[0].tag_redraw()
        yield 0.5
    check(not draw_errors, "\n".join(draw_errors))


def run(tests):
    bpy.ops.preferences.addon_install(filepath=ADDON)
    bpy.ops.preferences.addon_enable(module="stillray_addon")
    bpy.context.preferences.view.show_splash = False
    os.environ["STILLRAY"] = PROGRAM
    watch_panels()
    make_scene()
    properties = next(a for a in window().screen.areas if a.type == "PROPERTIES")
    properties.spaces.active.context = "RENDER"
    yield 0.5
    for test in tests:
        yield from test()
        print(f"window: {test.__name__} ... ok", flush=True)


TESTS = (test_undo_of_prepare, test_render_and_denoise,
         test_window_stays_alive_while_the_program_runs, test_esc_stops, test_button_stops,
         test_another_file_is_opened, test_before_and_after, test_panels)
steps = run((test_keyboard_stops_rendering,) if "keyboard" in ARGUMENTS else TESTS)


def tick():
    try:
        return next(steps)
    except StopIteration:
        os._exit(0)
    except BaseException:
        traceback.print_exc()
        sys.stdout.flush()
        os._exit(1)


bpy.app.timers.register(tick, first_interval=1.0, persistent=True)
