# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Settings of the add-on: of a scene, and of the user."""
import bpy
from bpy.props import (BoolProperty, CollectionProperty, EnumProperty, IntProperty, PointerProperty,
                       StringProperty)


class StillrayFinding(bpy.types.PropertyGroup):
    what: StringProperty()
    cure: StringProperty()
    aov: StringProperty()
    frames: StringProperty()


class StillraySettings(bpy.types.PropertyGroup):
    samples: IntProperty(
        name="Samples", default=4, min=1, soft_max=64,
        description="Samples per pixel that Prepare sets: 1 to 4 for drafts, 8 or 16 at the end")
    edges: EnumProperty(
        name="Edges", default="AUTO",
        items=[("AUTO", "Automatic Edges", "Smooth with 2 samples or more"),
               ("STABLE", "Stable Edges", "All samples at the centre of their pixel: textures and "
                "guides are the same in every frame, edges are not antialiased"),
               ("SMOOTH", "Smooth Edges", "Blender's own pixel filter: edges are antialiased")])
    window: EnumProperty(
        name="Light Of", default="auto",
        items=[("auto", "Automatic", "Past and future; the past alone where frames are missing"),
               ("both", "Past and Future", "A frame gets the light of frames before and after it: "
                "cleanest, also where things come into view"),
               ("past", "Past Only", "A frame gets the light of frames before it: half the time")])
    preset: EnumProperty(
        name="Quality", default="default",
        items=[("default", "High", "Follows light that changes, and keeps fine detail"),
               ("best", "Best", "As High, with sharper shadows and highlights. Takes longer, and runs "
                "on the CPU only"),
               ("temporal", "Only Gather", "Adds frames up without a filter: no blur, more noise"),
               ("svgf", "SVGF", "The filter of 2017 as published, for comparison")])
    passes: BoolProperty(
        name="Light Passes",
        description="Denoise every light pass too (Diffuse Direct, Glossy Indirect, ...), for "
                    "compositors that combine passes")
    fireflies: BoolProperty(
        name="Limit Fireflies", description="Limit single bright pixels to their neighbours. Takes about a "
                    "tenth of the light")
    smooth: BoolProperty(
        name="Smooth Edges in Time", default=True,
        description="Blend each frame with the last one along the motion: edges and textures are "
                    "smooth where the picture moves, also with stable edges. Not with light passes")
    all_layers: BoolProperty(
        name="All View Layers", default=True,
        description="Denoise every view layer, one after the other; off: the active one")
    folder: StringProperty(
        name="Folder", default="denoised",
        description="Folder of the denoised frames: a name beside the noisy ones, or a path")
    neighbours: IntProperty(
        name="Neighbours", default=8, min=0, soft_max=32,
        description="Frames to either side that Denoise This Frame takes light from")
    device: EnumProperty(
        name="Device", default="auto",
        items=[("auto", "Automatic", "A GPU with Vulkan if there is one, else the processor"),
               ("cpu", "CPU", "The processor"), ("vulkan", "GPU", "A GPU with Vulkan")])
    threads: IntProperty(
        name="Threads", default=0, min=0, max=4096, description="0: all processors")
    memory_limit: StringProperty(
        name="Memory Limit", description="Such as 8G; empty: the machine's memory")
    aovs: StringProperty(
        name="Layer Options", description="Values of --aov, separated by semicolons")
    # State, not set by users.
    saved: StringProperty(options={"HIDDEN"})
    prepared: BoolProperty(options={"HIDDEN"})
    findings: CollectionProperty(type=StillrayFinding)
    findings_known: BoolProperty(options={"HIDDEN"})
    show_changes: BoolProperty(name="Changed Settings", default=False)

    def set_findings(self, found, ranges):
        self.findings.clear()
        for item in found:
            row = self.findings.add()
            row.name, row.what, row.cure = item["name"], item["what"], item["cure"]
            row.aov, row.frames = item["aov"], ranges(item["frames"])
        self.findings_known = True


class StillrayPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: StringProperty(
        name="Program", subtype="FILE_PATH",
        description="Path of the program stillray; empty: the environment variable STILLRAY, PATH, "
                    "or the folder of the add-on")

    def draw(self, context):
        from . import operators  # which imports this module
        layout = self.layout
        layout.prop(self, "program")
        text, icon = operators.program_text(context)
        layout.label(text=text, icon=icon)


CLASSES = (StillrayFinding, StillraySettings, StillrayPreferences)


def preferences(context):
    addon = context.preferences.addons.get(__package__)
    return addon.preferences if addon is not None else None


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.stillray = PointerProperty(type=StillraySettings)


def unregister():
    del bpy.types.Scene.stillray
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
