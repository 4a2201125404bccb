# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Changes settings of a scene and brings them back.

What was changed is kept as JSON in a property of the scene, so that Restore works after saving and
loading. Without bpy: `resolve` gives the object that an owner's path means.
"""
import json
import math
import re


class Change:
    def __init__(self, owner, name, old, new):
        self.owner = owner
        self.name = name
        self.old = old
        self.new = new

    @property
    def key(self):
        return (self.owner, self.name)

    def text(self):
        return f"{title(self.owner)}{title(self.name)}: {_show(self.old)} → {_show(self.new)}"


_NAMES = {
    "use_motion_blur": "Motion Blur",
    "use_compositing": "Compositing", "use_sequencer": "Sequencer", "filepath": "Output Path",
    "file_format": "File Format", "media_type": "Media Type", "color_depth": "Color Depth",
    "color_mode": "Color", "exr_codec": "Codec", "use_exr_interleave": "Interleave",
    "use_adaptive_sampling": "Noise Threshold", "use_denoising": "Denoise",
    "use_animated_seed": "Seed changes with the frame", "samples": "Samples",
    "pixel_filter_type": "Pixel Filter", "filter_width": "Pixel Filter Width",
    "denoising_store_passes": "Pass Denoising Data", "use_pass_z": "Pass Z",
    "use_pass_emit": "Pass Emission", "use_dof": "Depth of Field", "engine": "Render Engine",
    "time_limit": "Time Limit", "use_file_extension": "File Extensions",
}


def title(name):
    """A setting or an owner as users know it."""
    quoted = re.match(r'(?:data\.)?\w+\["(.*)"\]', name)
    if quoted:
        return re.sub(r"\\(.)", r"\1", quoted[1]) + ", "
    if name in ("", "render", "cycles", "render.image_settings", "stillray"):
        return ""
    if name.startswith("use_pass_") and name not in _NAMES:
        return "Pass " + name[len("use_pass_"):].replace("_", " ").title()
    return _NAMES.get(name, name.replace("_", " ").capitalize())


def _show(value):
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:g}" if isinstance(value, float) else str(value)


def same(a, b):
    if isinstance(a, float) or isinstance(b, float):
        return math.isclose(a, b, rel_tol=1e-6, abs_tol=1e-9)
    return a == b


def load(text):
    """Changes of the scene's property; none if it is damaged."""
    try:
        return [Change(e["owner"], e["name"], e["old"], e["new"]) for e in json.loads(text or "[]")]
    except (ValueError, TypeError, KeyError):
        return []


def dump(changes):
    return json.dumps([{"owner": c.owner, "name": c.name, "old": c.old, "new": c.new}
                       for c in changes])


def _get(resolve, owner, name):
    try:
        return getattr(resolve(owner), name)
    except (AttributeError, KeyError, ValueError):
        return None


def _set(resolve, owner, name, value):
    try:
        setattr(resolve(owner), name, value)
        return True
    except (AttributeError, KeyError, TypeError, ValueError):
        return False


def apply(wanted, resolve, also_changed=()):
    """Sets (owner, name, value) in this order, and returns the changes.

    `also_changed` are (owner, name) that Blender changes by itself, as the colour depth with the
    file format. Second result: the names of settings that could not be set.
    """
    keys = list(dict.fromkeys([*also_changed, *((owner, name) for owner, name, _ in wanted)]))
    before = {key: _get(resolve, *key) for key in keys}
    for owner, name, value in wanted:
        if before[(owner, name)] is not None and not same(_get(resolve, owner, name), value):
            _set(resolve, owner, name, value)
    after = {key: _get(resolve, *key) for key in keys}
    failed = [title(name) for owner, name, value in wanted
              if before[(owner, name)] is not None and not same(after[(owner, name)], value)]
    changes = [Change(*key, before[key], after[key]) for key in keys
               if before[key] is not None and not same(before[key], after[key])]
    return changes, failed


def merge(saved, changes):
    """The oldest value of each setting stays; a setting that is back at it is no change."""
    merged = {c.key: c for c in saved}
    for change in changes:
        old = merged[change.key].old if change.key in merged else change.old
        merged.pop(change.key, None)
        if not same(old, change.new):
            merged[change.key] = Change(*change.key, old, change.new)
    return list(merged.values())


def restore(saved, resolve):
    """Brings old values back. Returns the changes that were undone, and those that were left
    because the setting has changed since or is gone."""
    undone = [c for c in saved if _get(resolve, *c.key) is not None
              and same(_get(resolve, *c.key), c.new)]
    left = [c for c in saved if c not in undone]
    # Twice: a value that depends on another one (colour depth on the format) may need it set first,
    # and setting that one may change it.
    for _ in range(2):
        for change in undone:
            if not same(_get(resolve, *change.key), change.old):
                _set(resolve, change.owner, change.name, change.old)
    failed = [c for c in undone if not same(_get(resolve, *c.key), c.old)]
    return [c for c in undone if c not in failed], left + failed
