#!/usr/bin/env python3
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Differences between versions of Blender, against stand-ins for the properties and types that each
version has according to its documentation. No Blender is needed."""
import sys
import types
import unittest

import addon_package

bpy = types.ModuleType("bpy")
bpy.types = types.SimpleNamespace()
bpy.data = types.SimpleNamespace()
sys.modules["bpy"] = bpy

from stillray_addon import versions  # noqa: E402

assert addon_package.package is not None


class Thing(types.SimpleNamespace):
    pass


class Links(list):
    def new(self, output, target):
        self.append((output, target))


class Nodes(list):
    def new(self, kind):
        node = Thing(bl_idname=kind, location=(0, 0), inputs=[f"{kind} in"],
                     outputs=[f"{kind} out"])
        self.append(node)
        return node


class Interface:
    def __init__(self):
        self.items_tree = []

    def new_socket(self, name, in_out, socket_type):
        self.items_tree.append(Thing(name=name, item_type="SOCKET", in_out=in_out,
                                     socket_type=socket_type))


class Tree(Thing):
    def __init__(self):
        super().__init__(nodes=Nodes(), links=Links(), interface=Interface())


class Compositor(unittest.TestCase):
    def setUp(self):
        bpy.types = Thing()
        bpy.data = Thing(node_groups=Thing(new=lambda name, kind: Tree()))

    def test_5_0_makes_a_node_group_with_an_output(self):
        scene = Thing(name="S", compositing_node_group=None, render=Thing(use_compositing=True))
        self.assertIsNone(versions.compositor_tree(scene))
        self.assertFalse(versions.compositor_is_on(scene))
        tree = versions.ensure_compositor_tree(scene)
        self.assertIs(scene.compositing_node_group, tree)
        self.assertEqual([n.bl_idname for n in tree.nodes],
                         ["CompositorNodeRLayers", "NodeGroupOutput"])
        self.assertEqual([(i.in_out, i.socket_type) for i in tree.interface.items_tree],
                         [("OUTPUT", "NodeSocketColor")])
        self.assertEqual(tree.links, [("CompositorNodeRLayers out", "NodeGroupOutput in")])
        self.assertTrue(versions.compositor_is_on(scene))
        versions.compositor_output(versions.ensure_compositor_tree(scene))
        self.assertEqual((len(tree.nodes), len(tree.interface.items_tree)), (2, 1))

    def test_3_4_uses_the_tree_of_the_scene(self):
        bpy.types = Thing(CompositorNodeComposite=object)
        scene = Thing(name="S", use_nodes=False, node_tree=Tree(),
                      render=Thing(use_compositing=True))
        self.assertIsNone(versions.compositor_tree(scene))
        self.assertIs(versions.ensure_compositor_tree(scene), scene.node_tree)
        self.assertTrue(scene.use_nodes)
        self.assertEqual(versions.compositor_output(scene.node_tree).bl_idname,
                         "CompositorNodeComposite")


class Properties(unittest.TestCase):
    def test_kind_of_media_is_set_before_the_format(self):
        old = Thing(file_format="PNG", color_depth="8", exr_codec="ZIP")
        new = Thing(media_type="IMAGE", use_exr_interleave=False, **vars(old))
        self.assertEqual([n for n, _ in versions.multilayer_settings(old)],
                         ["file_format", "color_depth", "exr_codec"])
        self.assertEqual(versions.multilayer_settings(new)[:2], [
            ("media_type", "MULTI_LAYER_IMAGE"), ("file_format", "OPEN_EXR_MULTILAYER")])
        self.assertIn(("use_exr_interleave", True), versions.multilayer_settings(new))
        self.assertEqual(versions.image_format_properties(new)[:2], ["media_type", "file_format"])

    def test_strips(self):
        self.assertEqual(versions.strips(Thing(sequences=[1])), [1])
        self.assertEqual(versions.strips(Thing(sequences=[1], strips=[2])), [2])
        self.assertFalse(versions.has_strips(Thing(sequence_editor=None)))
        self.assertFalse(versions.has_strips(Thing(sequence_editor=Thing(strips=[]))))
        self.assertEqual(versions.strip_end(Thing(frame_final_end=5)), 5)
        self.assertEqual(versions.strip_end(Thing(right_handle=6)), 6)

    def test_shutter(self):
        for position, expected in (("START", (0, 0.5)), ("CENTER", (-0.25, 0.25)),
                                   ("END", (-0.5, 0))):
            blur = {"use_motion_blur": True, "motion_blur_shutter": 0.5}
            old = Thing(render=Thing(**blur), cycles=Thing(motion_blur_position=position))
            new = Thing(render=Thing(motion_blur_position=position, **blur), cycles=Thing())
            self.assertEqual(versions.shutter(old), expected)
            self.assertEqual(versions.shutter(new), expected)
        self.assertEqual(versions.shutter(Thing(render=Thing(use_motion_blur=False))), (0, 0))

    def test_rolling_shutter(self):
        rolling = Thing(rolling_shutter_type="TOP", rolling_shutter_duration=0.1)
        self.assertEqual(versions.rolling_shutter(Thing(cycles=rolling)), 0.1)
        rolling.rolling_shutter_type = "NONE"
        self.assertIsNone(versions.rolling_shutter(Thing(cycles=rolling)))
        self.assertIsNone(versions.rolling_shutter(Thing(cycles=Thing())))

    def test_panorama_of_cycles_and_of_the_camera(self):
        rna = Thing(properties=[Thing(identifier="fisheye_fov"), Thing(identifier="lens")])
        own = Thing(panorama_type="FISHEYE", fisheye_fov=3, lens=50, bl_rna=rna)
        self.assertEqual(versions.panorama(own), ("FISHEYE", {"fisheye_fov": 3}))
        self.assertEqual(versions.panorama(Thing(cycles=own)), ("FISHEYE", {"fisheye_fov": 3}))
        self.assertEqual(versions.panorama(Thing()), ("", {}))

    def test_passes_that_a_version_lacks_are_left_out(self):
        layer = Thing(use_pass_z=False, use_pass_vector=False,
                      cycles=Thing(denoising_store_passes=False, use_pass_volume_direct=False))
        self.assertEqual(versions.pass_properties(layer, False), [
            ("", "use_pass_z"), ("", "use_pass_vector"), ("cycles", "denoising_store_passes")])
        self.assertIn(("cycles", "use_pass_volume_direct"), versions.pass_properties(layer, True))

    def test_progress(self):
        drawn = []
        versions.draw_progress(Thing(progress=lambda **named: drawn.append(named)), 0.5, "t")
        versions.draw_progress(Thing(label=lambda **named: drawn.append(named)), 0.5, "t")
        self.assertEqual(drawn[0], {"factor": 0.5, "text": "t"})
        self.assertEqual(drawn[1]["text"], "50 %  t")


if __name__ == "__main__":
    unittest.main()
