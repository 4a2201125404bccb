# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Blender add-on: renders few samples with Cycles and denoises the animation with `stillray`.

The program runs as a process of its own: its libraries (OpenEXR, TBB, Embree) exist in Blender too,
in other versions. Legacy add-on (3.4 to 4.1, by bl_info) and extension (4.2 and later, by
blender_manifest.toml) are the same folder.
"""
bl_info = {
    "name": "stillray: Denoise Animation",
    "author": "the stillray developers",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Properties > Render > stillray",
    "description": "Render few samples, and denoise the whole animation without flicker",
    "category": "Render",
}


def register():
    from . import cameras, operators, panel, properties
    properties.register()
    operators.register()
    panel.register()
    cameras.register()


def unregister():
    from . import cameras, operators, panel, properties
    cameras.unregister()
    panel.unregister()
    operators.unregister()
    properties.unregister()
