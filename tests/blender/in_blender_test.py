# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Tests of the add-on within Blender, on the CPU, with the real program.

    blender -b --factory-startup --python in_blender_test.py -- ADDON.zip STILLRAY FOLDER [TEST ...]

Frames are 96x54 with one sample. The folder's name has a space, quotes and an umlaut.
"""
import json
import os
import pathlib
import shutil
import stat
import sys
import threading
import time
import unittest

import bpy
import numpy
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector

ARGUMENTS = sys.argv[sys.argv.index("--") + 1:]
ADDON, PROGRAM, FOLDER = ARGUMENTS[:3]
FAKE = str(pathlib.Path(__file__).with_name("fake_stillray.py"))
WIDTH, HEIGHT = 96, 54
LAST = 4


def setUpModule():
    bpy.ops.preferences.addon_install(filepath=ADDON)
    bpy.ops.preferences.addon_enable(module="stillray_addon")
    global addon
    import stillray_addon as addon
    from stillray_addon import (advice, camera_math, cameras, exr_header,  # noqa: F401
                                flatten, job, operators, prepare, program, results, versions)


class SceneTest(unittest.TestCase):
    """A checkered floor, a cube and a lamp; the camera moves."""

    def setUp(self):
        os.environ["STILLRAY"] = PROGRAM
        addon.operators.active = None
        bpy.ops.wm.read_homefile(use_factory_startup=True)
        self.folder = os.path.join(FOLDER, self.id().rpartition(".")[2] + " \"ö' x")
        shutil.rmtree(self.folder, ignore_errors=True)
        os.makedirs(self.folder)
        self.scene = bpy.context.scene
        self.make_scene(self.scene)
        bpy.ops.wm.save_as_mainfile(filepath=os.path.join(self.folder, "my shot.blend"))

    @staticmethod
    def make_scene(scene):
        bpy.ops.mesh.primitive_plane_add(size=12, location=(0, 0, -1))
        material = bpy.data.materials.new("checker")
        material.use_nodes = True
        nodes = material.node_tree.nodes
        checker = nodes.new("ShaderNodeTexChecker")
        checker.inputs["Scale"].default_value = 6
        colour = nodes["Principled BSDF"].inputs["Base Color"]
        material.node_tree.links.new(checker.outputs[0], colour)
        bpy.context.object.data.materials.append(material)
        scene.objects["Light"].data.type = "AREA"
        light = scene.objects["Light"].data  # of another type now
        light.energy, light.size = 500, 3
        camera = scene.camera
        camera.keyframe_insert("location", frame=0)
        camera.location.x += 1
        camera.keyframe_insert("location", frame=LAST + 1)
        scene.frame_start, scene.frame_end = 1, LAST
        scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
        scene.stillray.samples = 1

    def prepared(self, render=True):
        self.assertEqual(bpy.ops.stillray.prepare(), {"FINISHED"})
        if render:
            bpy.ops.render.render(animation=True)
        return self.scene

    def noisy(self, frame):
        return os.path.join(self.folder, "render", f"my shot.{frame:04d}.exr")

    def clean(self, frame):
        return os.path.join(self.folder, "render", "denoised", f"my shot.{frame:04d}.exr")

    def pixels(self, file, layer=""):
        plain = os.path.join(self.folder, "plain.exr")
        addon.flatten.flatten(file, plain, layer)
        image = bpy.data.images.load(plain)
        values = numpy.array(image.pixels[:]).reshape(HEIGHT, WIDTH, 4)
        bpy.data.images.remove(image)
        return values

    def error_of(self, operator, **named):
        with self.assertRaises(RuntimeError) as caught:
            operator(**named)
        return str(caught.exception)

    def findings(self):
        return {f.name for f in self.scene.stillray.findings}


class Pipeline(SceneTest):
    def test_clean_frames_are_closer_to_a_converged_one(self):
        self.prepared(render=False)
        self.assertEqual(bpy.ops.stillray.render(), {"FINISHED"})
        scene = self.scene
        self.assertTrue(scene.stillray.findings_known)
        self.assertEqual([f.what for f in scene.stillray.findings], [])
        scene.cycles.samples = 256
        for frame in (2, LAST):
            scene.render.filepath = os.path.join(self.folder, "reference.exr")
            scene.frame_set(frame)
            bpy.ops.render.render(write_still=True)
            reference = self.pixels(scene.render.filepath)[..., :3]
            noisy, clean = (self.pixels(f(frame))[..., :3] for f in (self.noisy, self.clean))
            self.assertTrue(numpy.isfinite(clean).all())
            errors = [numpy.mean((p / (1 + p) - reference / (1 + reference)) ** 2)
                      for p in (noisy, clean)]
            ratio = errors[1] / errors[0]
            print(f"stillray test: error of clean over noisy frame {frame}: {ratio:.3f}")
            self.assertLess(ratio, 0.25)  # measured: 0.08

    def test_settings_of_the_render_are_as_before(self):
        self.prepared(render=False)
        scene = self.scene
        scene.use_nodes = True
        before = [getattr(scene.render, n) for n in ("use_compositing", "use_sequencer",
                                                     "use_overwrite", "use_placeholder")]
        bpy.ops.stillray.render()
        after = [getattr(scene.render, n) for n in ("use_compositing", "use_sequencer",
                                                    "use_overwrite", "use_placeholder")]
        self.assertEqual(before, after)
        layers = addon.exr_header.read(self.noisy(1)).channels
        self.assertFalse([c for c in layers if c.startswith("Composite.")])

    def test_options_reach_the_program(self):
        scene = self.prepared()
        values = scene.stillray
        values.window, values.preset, values.passes, values.fireflies = "past", "svgf", True, True
        values.device, values.threads, values.folder = "cpu", 1, "clean 'ü"
        bpy.ops.stillray.denoise()
        work = os.path.join(self.folder, "render", values.folder, addon.job.WORK)
        with open(os.path.join(work, "denoise1.json"), encoding="utf-8") as stream:
            log = json.load(stream)
        self.assertEqual((log["window"], log["preset"], log["threads"]), ("past", "svgf", 1))
        self.assertEqual(log["parameters"]["firefly"], "clamp")
        file = os.path.join(self.folder, "render", values.folder, "my shot.0002.exr")
        noisy, clean = (self.layer(f, "ViewLayer.DiffDir.R") for f in (self.noisy(2), file))
        self.assertFalse(numpy.array_equal(noisy, clean))

    def layer(self, file, channel):
        header = addon.exr_header.read(file)
        with open(file, "rb") as stream:
            reader = addon.flatten._Reader(stream, header, 0)
            return reader.rows()[:, reader.columns(channel)[0]]

    def test_nothing_is_done_twice_and_new_frames_are_noticed(self):
        self.prepared()
        bpy.ops.stillray.denoise()
        made = os.stat(self.clean(2)).st_mtime_ns
        bpy.ops.stillray.denoise()
        self.assertEqual(os.stat(self.clean(2)).st_mtime_ns, made)
        bpy.ops.stillray.denoise(again=True)
        self.assertNotEqual(os.stat(self.clean(2)).st_mtime_ns, made)
        made = os.stat(self.clean(2)).st_mtime_ns
        bpy.ops.render.render(animation=True)
        bpy.ops.stillray.denoise()
        self.assertNotEqual(os.stat(self.clean(2)).st_mtime_ns, made)

    def test_one_frame(self):
        self.prepared()
        self.scene.frame_set(3)
        self.scene.stillray.neighbours = 1
        self.assertEqual(bpy.ops.stillray.denoise_frame(), {"FINISHED"})
        single = os.path.join(os.path.dirname(self.clean(1)), "single")
        self.assertEqual(os.listdir(single), ["my shot.0003.exr"])
        noisy = self.pixels(self.noisy(3))
        clean = self.pixels(os.path.join(single, "my shot.0003.exr"))
        self.assertLess(numpy.diff(clean[..., 0]).std(), numpy.diff(noisy[..., 0]).std())
        self.scene.frame_end = 20
        self.scene.frame_set(15)
        self.assertIn("Frame 15 is not rendered; rendered are 1-4",
                      self.error_of(bpy.ops.stillray.denoise_frame))

    def test_names_that_look_like_patterns(self):
        self.prepared(render=False)
        self.scene.render.filepath = "//render/a*b[1]%d?.####"
        self.assertEqual(bpy.ops.stillray.render(), {"FINISHED"})
        self.assertTrue(os.path.isfile(os.path.join(self.folder, "render/denoised",
                                                    "a*b[1]%d?.0004.exr")))

    def test_unsaved_file(self):
        bpy.ops.wm.read_homefile(use_factory_startup=True)
        self.make_scene(bpy.context.scene)
        bpy.ops.stillray.prepare()
        self.assertIn("Save the file first", self.error_of(bpy.ops.stillray.render))


class Layers(SceneTest):
    def add_layer(self, name):
        layer = self.scene.view_layers.new(name)
        layer.layer_collection.children[0].exclude = False
        return layer

    def test_all_view_layers(self):
        self.add_layer("Only \"Büll\".001")
        self.prepared()
        bpy.ops.stillray.denoise()
        for layer in ("ViewLayer", "Only \"Büll\".001"):
            noisy, clean = self.pixels(self.noisy(2), layer), self.pixels(self.clean(2), layer)
            self.assertFalse(numpy.array_equal(noisy, clean), layer)
        work = os.path.join(os.path.dirname(self.clean(1)), addon.job.WORK)
        self.assertFalse([n for n in os.listdir(work) if n.startswith("layer")])
        made = os.stat(self.clean(2)).st_mtime_ns
        bpy.ops.stillray.denoise()
        self.assertEqual(os.stat(self.clean(2)).st_mtime_ns, made)

    def test_the_active_view_layer_alone(self):
        self.add_layer("Second")
        self.prepared()
        self.scene.stillray.all_layers = False
        bpy.ops.stillray.denoise()
        equal = [numpy.array_equal(self.pixels(self.noisy(2), layer),
                                   self.pixels(self.clean(2), layer))
                 for layer in ("ViewLayer", "Second")]
        self.assertEqual(equal, [False, True])

    def test_several_scenes(self):
        bpy.ops.scene.new(type="FULL_COPY")
        scene = bpy.context.scene
        self.assertNotEqual(scene.name, self.scene.name)
        bpy.ops.stillray.prepare()
        self.assertEqual(scene.render.filepath, f"//render/my shot {scene.name}.####")
        self.assertEqual(self.scene.render.filepath, "/tmp/")
        bpy.ops.stillray.render()
        self.assertEqual(len(os.listdir(os.path.join(self.folder, "render"))), LAST + 2)


class PrepareAndRestore(SceneTest):
    def state(self):
        scene, values = self.scene, {}
        owners = {"render": scene.render, "image": scene.render.image_settings,
                  "cycles": scene.cycles}
        for layer in scene.view_layers:
            owners[layer.name] = layer
            owners[layer.name + ".cycles"] = layer.cycles
        for owner, data in owners.items():
            for p in data.bl_rna.properties:
                if p.type in ("BOOLEAN", "INT", "FLOAT", "STRING", "ENUM") and not p.is_readonly:
                    value = getattr(data, p.identifier)
                    if isinstance(value, (bool, int, float, str)):
                        values[owner, p.identifier] = value
        return values

    def test_every_setting_comes_back(self):
        for codec, depth, mode in (("PNG", "16", "BW"), ("OPEN_EXR", "32", "RGB"),
                                   ("JPEG", "8", "BW")):
            bpy.ops.wm.read_homefile(use_factory_startup=True)
            self.scene = scene = bpy.context.scene
            scene.view_layers.new("a \"b\\")
            scene.render.image_settings.file_format = codec
            scene.render.image_settings.color_depth = depth
            scene.render.image_settings.color_mode = mode
            scene.render.use_motion_blur = True
            before = self.state()
            bpy.ops.stillray.prepare()
            changed = {key for key, value in self.state().items() if before[key] != value}
            self.assertIn(("render", "use_motion_blur"), changed)
            self.assertIn(("a \"b\\", "use_pass_vector"), changed)
            listed = {c.name for c in addon.operators.saved_changes(scene)}
            self.assertEqual({name for _, name in changed} - listed, set())
            self.assertEqual(bpy.ops.stillray.restore(), {"FINISHED"})
            self.assertEqual(self.state(), before)
            self.assertFalse(bpy.ops.stillray.restore.poll())

    def test_restore_after_saving_and_loading(self):
        before = self.state()
        bpy.ops.stillray.prepare()
        bpy.ops.stillray.prepare()
        bpy.ops.wm.save_mainfile()
        bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)
        self.scene = bpy.context.scene
        self.assertNotEqual(self.state(), before)
        bpy.ops.stillray.restore()
        self.assertEqual(self.state(), before)

    def test_later_changes_of_the_user_stay(self):
        bpy.ops.stillray.prepare()
        self.scene.cycles.samples = 77
        bpy.ops.stillray.restore()
        self.assertEqual(self.scene.cycles.samples, 77)
        self.assertFalse(self.scene.cycles.use_animated_seed)

    def test_prepared_scene_has_no_warnings(self):
        scene = self.scene
        scene.use_nodes = True
        scene.sequence_editor_create()
        addon.versions.strips(scene.sequence_editor).new_effect(
            name="c", type="COLOR", channel=1, frame_start=1, frame_end=5)
        scene.render.use_motion_blur = True
        names = {w.name for w in addon.prepare.warnings(scene)}
        self.assertEqual(names, {"engine", "format", "motion_blur", "fixed_seed", "denoiser",
                                 "adaptive", "compositor", "sequencer", "passes_missing"})
        bpy.ops.stillray.prepare()
        self.assertEqual([w.text for w in addon.prepare.warnings(scene)], [])
        codec = scene.render.image_settings
        self.assertEqual((codec.file_format, codec.color_depth, codec.exr_codec),
                         ("OPEN_EXR_MULTILAYER", "16", "ZIP"))

    def test_every_warning_is_cured_by_its_button(self):
        bpy.ops.stillray.prepare()
        scene = self.scene
        faults = {"motion_blur": (scene.render, "use_motion_blur", True),
                  "fixed_seed": (scene.cycles, "use_animated_seed", False),
                  "denoiser": (scene.cycles, "use_denoising", True),
                  "adaptive": (scene.cycles, "use_adaptive_sampling", True),
                  "depth_of_field": (scene.camera.data.dof, "use_dof", True),
                  "passes_missing": (scene.view_layers[0], "use_pass_vector", False),
                  "format": (scene.render.image_settings, "file_format", "PNG")}
        for name, (owner, attribute, value) in faults.items():
            setattr(owner, attribute, value)
            self.assertEqual([w.name for w in addon.prepare.warnings(scene)], [name])
            self.assertTrue(addon.prepare.can_cure(scene, name))
            self.assertEqual(bpy.ops.stillray.cure(name=name), {"FINISHED"})
            self.assertEqual(addon.prepare.warnings(scene), [], name)
            self.assertFalse(addon.prepare.can_cure(scene, name))
        bpy.ops.stillray.restore()
        self.assertTrue(scene.camera.data.dof.use_dof)

    def test_warnings_without_a_cure(self):
        bpy.ops.stillray.prepare()
        self.scene.frame_step, self.scene.render.use_multiview = 2, True
        camera, self.scene.camera = self.scene.camera, None
        self.assertEqual({w.name for w in addon.prepare.warnings(self.scene)},
                         {"step", "stereo", "camera"})
        self.assertIn("The scene has no camera", self.error_of(bpy.ops.stillray.render))
        self.scene.camera = camera
        self.assertIn("no setting", self.error_of(bpy.ops.stillray.cure, name="step"))

    def test_passes_of_volumes_only_where_there_are_volumes(self):
        layer = self.scene.view_layers[0]
        bpy.ops.stillray.prepare()
        self.assertFalse(layer.cycles.use_pass_volume_direct)
        tree = self.scene.world.node_tree
        volume = tree.nodes.new("ShaderNodeVolumeScatter")
        tree.links.new(volume.outputs[0], tree.nodes["World Output"].inputs["Volume"])
        bpy.ops.stillray.prepare()
        self.assertTrue(layer.cycles.use_pass_volume_direct)

    def test_a_path_of_the_user_stays(self):
        self.scene.render.filepath = "//mine/x_##"
        bpy.ops.stillray.prepare()
        self.assertEqual(self.scene.render.filepath, "//mine/x_##")

    def test_pixel_filter_follows_the_samples(self):
        for samples, edges, width in ((1, "AUTO", 0.01), (2, "AUTO", 1.5), (8, "STABLE", 0.01),
                                      (1, "SMOOTH", 1.5)):
            self.scene.stillray.samples, self.scene.stillray.edges = samples, edges
            bpy.ops.stillray.prepare()
            self.assertAlmostEqual(self.scene.cycles.filter_width, width)


class Faults(SceneTest):
    def test_no_frames(self):
        self.prepared(render=False)
        for operator in (bpy.ops.stillray.denoise, bpy.ops.stillray.check,
                         bpy.ops.stillray.denoise_frame):
            self.assertIn("no my shot.####.exr in", self.error_of(operator))
        for operator in (bpy.ops.stillray.show, bpy.ops.stillray.toggle,
                         bpy.ops.stillray.to_compositor, bpy.ops.stillray.to_sequencer):
            self.assertIn("Denoise first", self.error_of(operator))
        self.assertIsNone(addon.operators.active)

    def test_scene_that_is_not_prepared(self):
        self.assertIn("Press Prepare first", self.error_of(bpy.ops.stillray.render))

    def test_program_missing_or_old(self):
        self.prepared()
        os.environ["STILLRAY"] = "/nonexistent/stillray"
        self.assertIn("is not at /nonexistent", self.error_of(bpy.ops.stillray.denoise))
        self.assertIn("is not at /nonexistent", self.error_of(bpy.ops.stillray.render))
        os.environ["FAKE_STILLRAY"] = "old"
        self.addCleanup(os.environ.pop, "FAKE_STILLRAY")
        old = os.path.join(self.folder, "old")
        shutil.copy(FAKE, old)
        os.environ["STILLRAY"] = old
        self.assertIn("needs 0.1.0 or later", self.error_of(bpy.ops.stillray.check))

    def test_program_of_the_preferences_counts_first(self):
        self.prepared()
        os.environ["STILLRAY"] = "/nonexistent/stillray"
        preferences = bpy.context.preferences.addons["stillray_addon"].preferences
        preferences.program = PROGRAM
        self.addCleanup(setattr, preferences, "program", "")
        self.assertEqual(bpy.ops.stillray.denoise(), {"FINISHED"})

    def test_frames_missing_in_the_middle(self):
        self.prepared()
        os.remove(self.noisy(2))
        bpy.ops.stillray.denoise()
        self.assertTrue(os.path.isfile(self.clean(4)))
        self.assertFalse(os.path.isfile(self.clean(2)))
        self.assertIn("frames_missing", self.findings())
        others = {n: os.stat(self.noisy(n)).st_mtime_ns for n in (1, 3, 4)}
        self.assertEqual(bpy.ops.stillray.render(missing_only=True), {"FINISHED"})
        self.assertTrue(os.path.isfile(self.clean(2)))
        self.assertEqual(others, {n: os.stat(self.noisy(n)).st_mtime_ns for n in (1, 3, 4)})
        self.assertEqual(self.findings(), set())

    def test_damaged_frame(self):
        self.prepared()
        with open(self.noisy(3), "r+b") as stream:
            stream.truncate(os.path.getsize(self.noisy(3)) // 2)
        self.assertIn("Frame 3 cannot be used: it is cut off",
                      self.error_of(bpy.ops.stillray.denoise))
        bpy.ops.stillray.render(missing_only=True)
        self.assertEqual(addon.exr_header.fault(self.noisy(3)), "")

    def test_wrong_passes_are_found_and_cured(self):
        self.prepared(render=False)
        layer = self.scene.view_layers[0]
        layer.use_pass_vector = layer.use_pass_diffuse_color = False
        bpy.ops.render.render(animation=True)
        bpy.ops.stillray.check()
        self.assertIn("motion_missing", self.findings())
        finding = next(f for f in self.scene.stillray.findings if f.name == "motion_missing")
        self.assertTrue(finding.what and finding.cure)
        bpy.ops.stillray.cure(name="motion_missing")
        self.assertTrue(layer.use_pass_vector and layer.use_pass_diffuse_color)

    def test_picture_without_passes(self):
        self.prepared(render=False)
        self.scene.render.image_settings.file_format = "OPEN_EXR"
        bpy.ops.render.render(animation=True)
        bpy.ops.stillray.check()
        self.assertIn("single_layer", self.findings())
        bpy.ops.stillray.cure(name="single_layer")
        self.assertEqual(self.scene.render.image_settings.file_format, "OPEN_EXR_MULTILAYER")

    def test_fixed_seed_is_found(self):
        self.prepared(render=False)
        self.scene.cycles.use_animated_seed = False
        bpy.ops.render.render(animation=True)
        bpy.ops.stillray.denoise()
        self.assertIn("fixed_seed", self.findings())
        bpy.ops.stillray.cure(name="fixed_seed")
        self.assertTrue(self.scene.cycles.use_animated_seed)

    def test_a_finding_with_a_layer_option(self):
        self.prepared()
        finding = self.scene.stillray.findings.add()
        finding.name, finding.aov = "motion_y_flipped", "motion=ViewLayer.Vector,pixels,y_down"
        bpy.ops.stillray.cure(name="motion_y_flipped")
        bpy.ops.stillray.cure(name="motion_y_flipped")
        self.assertEqual(self.scene.stillray.aovs, finding.aov)
        bpy.ops.stillray.denoise()
        with open(os.path.join(os.path.dirname(self.clean(1)), addon.job.WORK, "stillray.log"),
                  encoding="utf-8") as stream:
            self.assertIn(finding.aov, stream.read())

    def test_disk_full(self):
        """A limit on the size of files stands for the full disk; the real program meets it."""
        self.prepared()
        limited = os.path.join(self.folder, "limited")
        with open(limited, "w", encoding="utf-8") as stream:
            stream.write(f"#!/bin/bash\ntrap '' XFSZ\nulimit -f 4\nexec '{PROGRAM}' \"$@\"\n")
        os.chmod(limited, 0o755)
        os.environ["STILLRAY"] = limited
        self.assertRegex(self.error_of(bpy.ops.stillray.denoise), "stillray: .*my shot.0001.exr.*")
        self.assertIsNone(addon.operators.active)
        os.environ["STILLRAY"] = PROGRAM
        self.assertEqual(bpy.ops.stillray.denoise(), {"FINISHED"})

    def test_folder_that_cannot_be_written_to(self):
        self.prepared()
        with open(os.path.join(self.folder, "render", "denoised"), "w", encoding="utf-8"):
            pass
        self.assertIn("cannot be made", self.error_of(bpy.ops.stillray.denoise))


class Interrupted(SceneTest):
    def fake(self, mode):
        """The stand-in for the program, on frames of these names."""
        os.environ["FAKE_STILLRAY"], os.environ["STILLRAY"] = mode, FAKE
        self.addCleanup(os.environ.pop, "FAKE_STILLRAY", None)
        self.scene.render.filepath = "//render/f.####"
        self.scene.frame_end = 3
        bpy.ops.render.render(animation=True)

    def cancel_after(self, seconds):
        def cancel():
            time.sleep(seconds)
            bpy.ops.stillray.cancel()
        thread = threading.Thread(target=cancel)
        thread.start()
        self.addCleanup(thread.join)

    def test_cancelled_run_resumes(self):
        self.prepared(render=False)
        self.fake("slow")
        self.cancel_after(3)
        self.assertEqual(bpy.ops.stillray.denoise(), {"CANCELLED"})
        self.assertIsNone(addon.operators.active)
        os.environ["FAKE_STILLRAY"] = "ok"
        self.assertEqual(bpy.ops.stillray.denoise(), {"FINISHED"})
        log = os.path.join(self.folder, "render/denoised", addon.job.WORK, "stillray.log")
        with open(log, encoding="utf-8") as stream:
            self.assertIn("resuming with frame", stream.read())

    def test_two_runs_at_once(self):
        self.prepared()
        work = os.path.join(os.path.dirname(self.clean(1)), addon.job.WORK)
        os.makedirs(work)
        held = addon.job.lock.Lock(os.path.join(work, "lock"))
        held.acquire()
        self.assertIn("are being denoised already", self.error_of(bpy.ops.stillray.denoise))
        held.release()
        self.assertEqual(bpy.ops.stillray.denoise(), {"FINISHED"})

    def test_one_run_in_one_blender(self):
        self.prepared()
        addon.operators.active = addon.operators._Active("x")
        self.assertIn("at work already", self.error_of(bpy.ops.stillray.denoise))
        addon.operators.active = None
        self.assertEqual(bpy.ops.stillray.cancel(), {"CANCELLED"})


class Cameras(SceneTest):
    def document(self, name="my shot"):
        file = os.path.join(self.folder, "render", name + ".cameras.json")
        with open(file, encoding="utf-8") as stream:
            return json.load(stream)

    def expected(self, frame, points):
        """Positions in the picture by Blender's own function, which uses no projection matrix."""
        self.scene.frame_set(frame)
        found = []
        for point in points:
            u, v, _ = world_to_camera_view(self.scene, self.scene.camera, Vector(point))
            found.append((u, v))
        return found

    def projected(self, record, points):
        view = numpy.array(record["world_to_camera"]).reshape(4, 4)
        projection = numpy.array(record["projection"]).reshape(4, 4)
        found = []
        for point in points:
            clip = projection @ view @ numpy.array([*point, 1.0])
            found.append(tuple((clip[:2] / clip[3] + 1) / 2))
        return found

    points = ((0, 0, 0), (1, -1, 0.5), (-2, 1, -1), (0.3, 2, 1))

    def check_projection(self, frame=2, border=None):
        bpy.ops.stillray.write_cameras()
        document = self.document()
        record = next(f for f in document["frames"] if f["frame"] == frame)
        for (u, v), (x, y) in zip(self.expected(frame, self.points),
                                  self.projected(record, self.points)):
            if border is not None:
                u = (u - border[0]) / (border[2] - border[0])
                v = (v - border[1]) / (border[3] - border[1])
            self.assertAlmostEqual(u, x, places=4)
            self.assertAlmostEqual(v, y, places=4)
        return document, record

    def test_perspective(self):
        self.prepared(render=False)
        document, record = self.check_projection()
        self.assertEqual((document["version"], document["width"], document["height"]),
                         (1, WIDTH, HEIGHT))
        self.assertEqual([f["frame"] for f in document["frames"]], [1, 2, 3, 4])
        self.assertEqual((record["type"], record["shutter"]), ("perspective", [0, 0]))
        data = self.scene.camera.data
        self.assertAlmostEqual(record["near"], data.clip_start)
        self.assertAlmostEqual(record["far"], data.clip_end)
        # z of clip space runs from -1 at the near plane to 1 at the far plane.
        for z, expected in ((-data.clip_start, -1), (-data.clip_end, 1)):
            row = numpy.array(record["projection"]).reshape(4, 4) @ numpy.array([0, 0, z, 1])
            self.assertAlmostEqual(row[2] / row[3], expected, places=4)

    def test_shift_aspect_and_sensor(self):
        self.prepared(render=False)
        data, render = self.scene.camera.data, self.scene.render
        data.shift_x, data.shift_y = 0.2, -0.1
        self.check_projection()
        render.pixel_aspect_x, render.pixel_aspect_y = 1.0, 1.5
        self.check_projection()
        data.sensor_fit = "VERTICAL"
        self.check_projection()
        render.resolution_percentage = 50
        document, _ = self.check_projection()
        self.assertEqual((document["width"], document["height"]), (WIDTH // 2, HEIGHT // 2))

    def test_orthographic(self):
        self.prepared(render=False)
        self.scene.camera.data.type = "ORTHO"
        self.scene.camera.data.shift_x = 0.1
        _, record = self.check_projection()
        self.assertEqual(record["type"], "orthographic")
        self.assertEqual(record["projection"][12:], [0, 0, 0, 1])

    def test_scaled_and_rolled(self):
        self.prepared(render=False)
        parent = bpy.data.objects.new("parent", None)
        self.scene.collection.objects.link(parent)
        parent.scale, parent.rotation_euler = (2, 2, 2), (0.1, 0.2, 0.3)
        self.scene.camera.parent = parent
        self.scene.camera.rotation_euler[1] += 0.7
        self.check_projection()

    def test_cropped(self):
        self.prepared(render=False)
        render = self.scene.render
        render.use_border = render.use_crop_to_border = True
        render.border_min_x, render.border_max_x = 0.25, 0.75
        render.border_min_y, render.border_max_y = 1 / 9, 8 / 9
        document, _ = self.check_projection(border=(0.25, 1 / 9, 0.75, 8 / 9))
        bpy.ops.render.render(animation=True)
        window = addon.exr_header.read(self.noisy(1)).parts[0]
        self.assertEqual((document["width"], document["height"]), (48, window.lines))

    def test_panoramic(self):
        self.prepared(render=False)
        self.scene.camera.data.type = "PANO"
        self.scene.camera.data.cycles.panorama_type = "FISHEYE_EQUIDISTANT"
        bpy.ops.stillray.write_cameras()
        record = self.document()["frames"][0]
        self.assertEqual((record["type"], record["projection"]), ("panoramic", None))
        self.assertEqual(record["panorama"]["kind"], "fisheye_equidistant")
        self.assertIn("fisheye_fov", record["panorama"])
        names = addon.prepare.frame_names(self.scene)
        file = addon.cameras.file_of(names)
        self.assertFalse(addon.camera_math.can_be_used(file, names, [1]))

    def test_markers_switch_cameras(self):
        self.prepared(render=False)
        other = bpy.data.objects.new("Other", bpy.data.cameras.new("Other"))
        self.scene.collection.objects.link(other)
        other.location.z = 9
        for name, frame, camera in (("a", 1, self.scene.camera), ("b", 3, other)):
            self.scene.timeline_markers.new(name, frame=frame).camera = camera
        bpy.ops.render.render(animation=True)
        self.assertEqual([f["camera"] for f in self.document()["frames"]],
                         ["Camera", "Camera", "Other", "Other"])

    def test_rendering_writes_the_same(self):
        self.prepared()
        rendered = self.document()
        os.remove(os.path.join(self.folder, "render", "my shot.cameras.json"))
        bpy.ops.stillray.write_cameras()
        for a, b in zip(rendered["frames"], self.document()["frames"]):
            numpy.testing.assert_allclose(a.pop("world_to_camera"), b.pop("world_to_camera"),
                                          atol=1e-6)
            numpy.testing.assert_allclose(a.pop("projection"), b.pop("projection"), atol=1e-6)
            self.assertEqual(a, b)

    def test_only_of_prepared_scenes(self):
        self.prepared(render=False)
        self.scene.stillray.prepared = False
        bpy.ops.render.render(animation=True)
        self.assertFalse([n for n in os.listdir(os.path.dirname(self.noisy(1))) if "json" in n])

    def test_motion_blur(self):
        self.prepared(render=False)
        self.scene.render.use_motion_blur = True
        self.scene.render.motion_blur_shutter = 0.5
        self.scene.cycles.rolling_shutter_type = "TOP"
        bpy.ops.render.render(animation=True)
        record = self.document()["frames"][1]
        self.assertEqual(record["shutter"], [-0.25, 0.25])
        self.assertAlmostEqual(record["rolling_shutter"], 0.1)
        self.assertEqual(sorted(pose["time"] for pose in record["motion"]), [-0.25, 0.25])
        for pose in record["motion"]:
            self.scene.frame_set(2 + int(pose["time"] // 1), subframe=pose["time"] % 1)
            expected = self.scene.camera.matrix_world.inverted()
            numpy.testing.assert_allclose(pose["world_to_camera"],
                                          [v for row in expected for v in row], atol=1e-5)


class Results(SceneTest):
    def setUp(self):
        super().setUp()
        self.prepared()
        bpy.ops.stillray.denoise()

    def rendered(self, frame):
        """The picture that Blender writes now, without a view transform."""
        self.scene.frame_set(frame)
        settings = self.scene.render.image_settings
        settings.file_format, settings.color_depth = "OPEN_EXR", "32"
        self.scene.render.filepath = os.path.join(self.folder, "result.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(self.scene.render.filepath)
        values = numpy.array(image.pixels[:]).reshape(HEIGHT, WIDTH, 4)
        bpy.data.images.remove(image)
        return values[..., :3]

    def test_image(self):
        self.assertEqual(bpy.ops.stillray.show(), {"FINISHED"})
        self.assertEqual(bpy.ops.stillray.toggle(), {"FINISHED"})
        images = [bpy.data.images[f"Scene {role}"] for role in ("noisy", "denoised")]
        self.assertEqual([i.source for i in images], ["SEQUENCE"] * 2)
        self.assertEqual([bpy.path.abspath(i.filepath) for i in images],
                         [self.noisy(1), self.clean(1)])
        bpy.ops.stillray.show()
        self.assertEqual(len([i for i in bpy.data.images if i.name.startswith("Scene ")]), 2)

    def test_new_compositor(self):
        self.assertEqual(bpy.ops.stillray.to_compositor(), {"FINISHED"})
        expected = self.pixels(self.clean(3))[..., :3]
        numpy.testing.assert_allclose(self.rendered(3), expected, rtol=1e-3, atol=1e-3)

    def test_existing_compositor(self):
        scene = self.scene
        scene.use_nodes = True
        tree = scene.node_tree
        layers, output = tree.nodes["Render Layers"], tree.nodes["Composite"]
        gain = tree.nodes.new("CompositorNodeExposure")
        gain.inputs["Exposure"].default_value = 1
        tree.links.new(layers.outputs["Image"], gain.inputs[0])
        tree.links.new(gain.outputs[0], output.inputs[0])
        depth = tree.nodes.new("CompositorNodeNormalize")
        tree.links.new(layers.outputs["Depth"], depth.inputs[0])
        for _ in range(2):  # a second time changes nothing
            bpy.ops.stillray.to_compositor()
            nodes = [n for n in tree.nodes if n.bl_idname == "CompositorNodeImage"]
            self.assertEqual(len(nodes), 1)
            self.assertTrue(layers.mute)
            self.assertEqual(depth.inputs[0].links[0].from_socket.name, "Depth")
        expected = 2 * self.pixels(self.clean(2))[..., :3]
        numpy.testing.assert_allclose(self.rendered(2), expected, rtol=1e-3, atol=1e-3)

    def test_every_view_layer_has_a_node_of_its_own(self):
        scene = self.scene
        scene.view_layers.new("Second")
        bpy.ops.stillray.prepare()
        bpy.ops.stillray.render()
        scene.use_nodes = True
        tree = scene.node_tree
        second = tree.nodes.new("CompositorNodeRLayers")
        second.layer = "Second"
        mix = tree.nodes.new("CompositorNodeMixRGB")
        tree.links.new(tree.nodes["Render Layers"].outputs["Image"], mix.inputs[1])
        tree.links.new(second.outputs["Image"], mix.inputs[2])
        tree.links.new(mix.outputs[0], tree.nodes["Composite"].inputs[0])
        bpy.ops.stillray.to_compositor()
        layers = [mix.inputs[i].links[0].from_node.layer for i in (1, 2)]
        self.assertEqual(layers, ["ViewLayer", "Second"])

    def test_sequencer(self):
        for _ in range(2):
            self.assertEqual(bpy.ops.stillray.to_sequencer(), {"FINISHED"})
            strips = list(addon.versions.strips(self.scene.sequence_editor))
            self.assertEqual([s.name for s in strips], ["Scene denoised"])
        strip = strips[0]
        self.assertEqual((strip.frame_start, addon.versions.strip_end(strip)), (1, LAST + 1))
        self.scene.render.use_sequencer = True
        expected = self.pixels(self.clean(3))[..., :3]
        numpy.testing.assert_allclose(self.rendered(3), expected, rtol=2e-3, atol=2e-3)

    def test_noisy_frames_come_from_cycles_whatever_is_set_up(self):
        bpy.ops.stillray.to_compositor()
        bpy.ops.stillray.to_sequencer()
        self.scene.render.use_sequencer = True
        bpy.ops.stillray.render()
        channels = addon.exr_header.read(self.noisy(2)).channels
        self.assertIn("ViewLayer.DiffDir.R", channels)


class Findings(unittest.TestCase):
    def test_every_finding_has_a_button_or_advice(self):
        """No finding needs the command line."""
        page = pathlib.Path(__file__).resolve().parents[2] / "docs/check.md"
        rows = page.read_text(encoding="utf-8").split("## Findings")[1].split("\n## ")[0]
        names = {name for row in rows.splitlines() if row.startswith("| `")
                 for name in row.split("|")[1].replace("`", "").replace(" ", "").split(",")}
        self.assertGreater(len(names), 40)
        known = set(addon.prepare.CURES) | set(addon.advice.TEXTS) | {"frames_missing"}
        self.assertEqual(names - known, set())
        self.assertEqual(set(addon.advice.TEXTS) - names, set())
        for text in addon.advice.TEXTS.values():
            self.assertNotIn("--", text)


class Installation(SceneTest):
    def test_where_it_is(self):
        scripts = os.environ["BLENDER_USER_SCRIPTS"]
        self.assertEqual(os.path.commonpath([addon.__file__, scripts]), scripts)
        self.assertEqual(addon.bl_info["version"], (0, 1, 0))

    def test_off_and_on_again(self):
        handlers = len(bpy.app.handlers.render_init)
        bpy.ops.preferences.addon_disable(module="stillray_addon")
        self.assertFalse(hasattr(bpy.types.Scene, "stillray"))
        self.assertEqual(len(bpy.app.handlers.render_init), handlers - 1)
        bpy.ops.preferences.addon_enable(module="stillray_addon")
        self.assertEqual(len(bpy.app.handlers.render_init), handlers)
        setUpModule()

    def test_every_operator_is_tested(self):
        source = pathlib.Path(__file__).read_text(encoding="utf-8")
        for cls in addon.operators.CLASSES:
            self.assertIn(f"bpy.ops.{cls.bl_idname}", source)


def main():
    assert stat.S_ISREG(os.stat(PROGRAM).st_mode), PROGRAM
    result = unittest.main(module=__name__, argv=["in_blender_test", *ARGUMENTS[3:]], exit=False,
                           verbosity=2).result
    sys.stdout.flush()
    os._exit(0 if result.wasSuccessful() and result.testsRun > 0 else 1)


main()
