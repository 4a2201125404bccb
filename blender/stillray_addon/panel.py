# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""The panel in the render properties."""
import bpy

from . import advice, operators, prepare, versions

_LETTER = 5.6  # pixels of a letter of Blender's font at a resolution scale of 1, on average
_MARGINS = 110  # pixels of icons, buttons and borders


def _letters(context):
    """Letters in a line of the panel; Blender's labels do not wrap."""
    scale = context.preferences.system.ui_scale
    return max(int((context.region.width / scale - _MARGINS) / _LETTER), 16)


def wrap(text, width):
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > width:
            lines.append("")
        lines[-1] += (" " if lines[-1] else "") + word
    return lines


def _draw_text(context, layout, text, icon):
    column = layout.column(align=True)
    for i, line in enumerate(wrap(text, _letters(context))):
        column.label(text=line, icon=icon if i == 0 else "BLANK1")


class _Panel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"


class STILLRAY_PT_main(_Panel, bpy.types.Panel):
    bl_idname = "STILLRAY_PT_main"
    bl_label = "stillray: Denoise Animation"

    def draw(self, context):
        scene, layout = context.scene, self.layout
        text, icon = operators.program_text(context)
        if icon == "ERROR":
            _draw_text(context, layout.box(), text, icon)
        self._draw_prepare(scene, layout)
        self._draw_warnings(context, layout)
        if operators.active is not None:
            self._draw_progress(layout)
        else:
            self._draw_run(layout)

    @staticmethod
    def _draw_prepare(scene, layout):
        row = layout.row(align=True)
        row.prop(scene.stillray, "samples")
        row.prop(scene.stillray, "edges", text="")
        row = layout.row(align=True)
        row.operator("stillray.prepare", icon="PREFERENCES")
        row.operator("stillray.restore", icon="LOOP_BACK")
        changes = operators.saved_changes(scene)
        if not changes:
            return
        layout.prop(scene.stillray, "show_changes", text=f"{len(changes)} settings were changed",
                    icon="TRIA_DOWN" if scene.stillray.show_changes else "TRIA_RIGHT", emboss=False)
        if scene.stillray.show_changes:
            column = layout.box().column(align=True)
            for change in changes:
                column.label(text=change.text())

    @staticmethod
    def _draw_warnings(context, layout):
        scene = context.scene
        for warning in prepare.warnings(scene):
            row = layout.row()
            _draw_text(context, row, warning.text, "CANCEL" if warning.blocks else "ERROR")
            if prepare.can_cure(scene, warning.name):
                row.operator("stillray.cure", text="", icon="CHECKMARK").name = warning.name

    @staticmethod
    def _draw_progress(layout):
        box = layout.box()
        versions.draw_progress(box, operators.active.fraction, operators.active.text)
        box.operator("stillray.cancel", icon="CANCEL")

    @staticmethod
    def _draw_run(layout):
        column = layout.column()
        column.scale_y = 1.4
        column.operator("stillray.render", icon="RENDER_ANIMATION")
        column = layout.column(align=True)
        column.operator("stillray.denoise", icon="IMAGE_DATA")
        row = column.row(align=True)
        row.operator("stillray.denoise_frame", icon="RENDER_STILL")
        row.operator("stillray.check", icon="VIEWZOOM")
        row = column.row(align=True)
        row.operator("stillray.render", text="Render Missing Frames",
                     icon="FILE_REFRESH").missing_only = True
        row.operator("stillray.denoise", text="Denoise Again", icon="FILE_REFRESH").again = True


class STILLRAY_PT_findings(_Panel, bpy.types.Panel):
    bl_idname = "STILLRAY_PT_findings"
    bl_parent_id = "STILLRAY_PT_main"
    bl_label = "Findings"

    @classmethod
    def poll(cls, context):
        return context.scene.stillray.findings_known

    def draw(self, context):
        scene, layout = context.scene, self.layout
        if not scene.stillray.findings:
            layout.label(text="Nothing wrong was found in the frames", icon="CHECKMARK")
        for finding in scene.stillray.findings:
            box = layout.box()
            _draw_text(context, box, finding.what[:1].upper() + finding.what[1:], "ERROR")
            if finding.name == "frames_missing":
                box.operator("stillray.render", text="Render Missing Frames").missing_only = True
            elif finding.aov:
                box.operator("stillray.cure", text="Read the layer so").name = finding.name
            elif prepare.can_cure(scene, finding.name):
                cure = prepare.CURES[finding.name][0]
                box.operator("stillray.cure", text=cure, icon="CHECKMARK").name = finding.name
            elif finding.name in prepare.CURES:
                _draw_text(context, box, prepare.WITHOUT_SETTING.get(
                    finding.name, "The settings are right now: render again"), "FILE_REFRESH")
            else:
                _draw_text(context, box, advice.text(finding.name, finding.cure), "INFO")


class STILLRAY_PT_options(_Panel, bpy.types.Panel):
    bl_idname = "STILLRAY_PT_options"
    bl_parent_id = "STILLRAY_PT_main"
    bl_label = "Options"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, values = self.layout, context.scene.stillray
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in ("preset", "window", "smooth", "fireflies", "passes", "all_layers", "neighbours",
                     "folder", "device", "threads", "memory_limit", "aovs"):
            layout.prop(values, name)
        layout.operator("stillray.write_cameras", icon="CAMERA_DATA")


class STILLRAY_PT_results(_Panel, bpy.types.Panel):
    bl_idname = "STILLRAY_PT_results"
    bl_parent_id = "STILLRAY_PT_main"
    bl_label = "Results"

    def draw(self, context):
        layout = self.layout
        row = layout.row(align=True)
        row.operator("stillray.show", icon="IMAGE_DATA")
        row.operator("stillray.toggle", icon="ARROW_LEFTRIGHT")
        row = layout.row(align=True)
        row.operator("stillray.to_compositor", icon="NODETREE")
        row.operator("stillray.to_sequencer", icon="SEQ_SEQUENCER")


CLASSES = (STILLRAY_PT_main, STILLRAY_PT_findings, STILLRAY_PT_results, STILLRAY_PT_options)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
