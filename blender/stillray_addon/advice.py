# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""What an animator can do about findings that no setting cures, without bpy.

The program's own cures name options of its command line. Findings that are missing here have a
button (prepare.CURES), or are shown with the program's words.
"""

_AGAIN = ("Something changed these frames after Cycles rendered them, or they come from another "
          "renderer: render them again")
_VECTORS = ("Cycles writes right vectors by itself. Surfaces that only a shader moves, and plain "
            "pictures without textures, can raise this by mistake: if moving edges of the result "
            "are clean, leave it")
_MIRRORS = ("Reflections are blurred where this happens. It is harmless unless they are important; "
            "then turn the pass Denoising Data off and render again")

TEXTS = {
    "size_changes": "Some frames have another size: render all of them again",
    "not_finite": "Single pixels are not numbers, and are filled from their neighbours. Look for "
                  "materials that divide by zero",
    "negative_light": "A light or a material has a negative strength or colour",
    "motion_zoom": "The focal length changes, and Cycles' vectors leave that out: move the camera "
                   "instead, or accept more noise during the zoom",
    "depth_constant": _AGAIN, "depth_negative": _AGAIN, "depth_normalised": _AGAIN,
    "depth_projected": _AGAIN, "depth_reversed": _AGAIN, "depth_not_linear": _AGAIN,
    "depth_ray": "Panoramic cameras write the distance and not the depth: edges are softer",
    "background_finite": _AGAIN,
    "normal_encoded": _AGAIN, "normal_not_encoded": _AGAIN, "normal_length": _AGAIN,
    "normal_zero": _AGAIN, "normal_camera_space": _AGAIN,
    "albedo_above_one": "A base colour is above 1, or a material has subsurface scattering, which "
                        "Cycles counts twice. Textures there lose a little detail",
    "albedo_black": "Materials that mix diffuse light without a colour: they lose detail",
    "albedo_encoded": _AGAIN, "light_encoded": _AGAIN, "light_tone_mapped": _AGAIN,
    "exposure_changes": "The brightness of the whole picture changes: keep Film > Exposure "
                        "constant, and change it in the compositor",
    "id_unstable": "Objects change their names, or are made anew in each frame: turn the pass "
                   "Cryptomatte Object off",
    "image_depth_nearer": _MIRRORS, "image_motion_wrong": _MIRRORS,
    "confidence_range": _AGAIN,
}
for _name in ("motion_direction", "motion_y_flipped", "motion_x_flipped", "motion_swapped",
              "motion_fraction", "motion_ndc", "motion_pixels", "motion_scaled", "motion_wrong"):
    TEXTS[_name] = _VECTORS


def text(name, cure):
    return TEXTS.get(name, cure)
