# SPDX-License-Identifier: Apache-2.0
"""The render engine "Gnomon": light that is remembered from frame to frame."""
from __future__ import annotations

bl_info = {
    "name": "Gnomon",
    "author": "The authors of Gnomon",
    "version": (0, 3, 0),
    "blender": (3, 4, 0),
    "location": "Render Properties > Render Engine",
    "description": "Render engine that lights animations without noise and recomputes only what changed",
    "doc_url": "",
    "category": "Render",
}

import bpy

from . import engine, panels, properties


class GnomonPreferences(bpy.types.AddonPreferences):
    """Where the Python package is."""

    bl_idname = __package__

    folder: bpy.props.StringProperty(   # type: ignore[valid-type]
        name="Folder of the Python package", subtype="DIR_PATH",
        description="the folder that contains the Python package gnomon, if Blender's Python does not find it")

    def draw(self, context) -> None:
        self.layout.prop(self, "folder")
        from . import library

        if library.find(self.folder) is None:
            self.layout.label(text=library.problem(), icon="ERROR")


_CLASSES = (GnomonPreferences, properties.GnomonSceneSettings, engine.GnomonRenderEngine, *panels.CLASSES)


def register() -> None:
    for each in _CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.gnomon = bpy.props.PointerProperty(type=properties.GnomonSceneSettings)
    panels.share()


def unregister() -> None:
    panels.unshare()
    del bpy.types.Scene.gnomon
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
