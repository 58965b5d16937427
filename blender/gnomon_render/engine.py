# SPDX-License-Identifier: Apache-2.0
"""The render engine: final renders, and what a viewport asks for."""
from __future__ import annotations

import sys
import traceback
from typing import Any

import bpy
import numpy as np

from . import library

ENGINE = "GNOMON"


class GnomonRenderEngine(bpy.types.RenderEngine):
    """Renders with Gnomon. With Persistent Data, Blender keeps the engine from frame to frame, and with it the renderers:
    each frame then costs what its changes cost."""

    bl_idname = ENGINE
    bl_label = "Gnomon"
    bl_use_preview = False
    bl_use_shading_nodes_custom = False   # materials are those of Cycles
    bl_use_eevee_viewport = True
    bl_use_gpu_context = False

    def __del__(self) -> None:
        try:
            parts = [*getattr(self, "_layers", {}).values(), getattr(self, "_viewport", None)]
        except ReferenceError:
            return   # Blender has removed it already, and with it its attributes
        for part in parts:
            if part is not None:
                part.close()

    def _loaded(self) -> bool:
        preferences = bpy.context.preferences.addons.get(__package__)
        folder = preferences.preferences.folder if preferences is not None else ""
        if library.find(folder) is None:
            self.report({"ERROR"}, library.problem())
            self.error_set(library.problem())
            return False
        return True

    def _state(self, name: str, make) -> Any:
        # Blender makes engines without calling __init__.
        if not hasattr(self, name):
            setattr(self, name, make())
        return getattr(self, name)

    def warn(self, what: str) -> None:
        """Tells the user of something once."""
        told = self._state("_told", set)
        if what in told:
            return
        told.add(what)
        print(f"gnomon: {what}", file=sys.stderr)
        self.report({"WARNING"}, what)

    # Final renders.

    def update_render_passes(self, scene, renderlayer) -> None:
        from . import passes

        passes.register_passes(self, scene, renderlayer)

    def update(self, data, depsgraph) -> None:
        if not self._loaded():
            return
        from .final import LayerRender

        layers = self._state("_layers", dict)
        name = depsgraph.view_layer.name
        if name not in layers:
            layers[name] = LayerRender(self)
        try:
            layers[name].update(depsgraph)
        except Exception as error:
            self._fail(error)

    def render(self, depsgraph) -> None:
        layer = getattr(self, "_layers", {}).get(depsgraph.view_layer.name)
        if layer is None:
            return
        try:
            layer.render(depsgraph)
        except Exception as error:
            layer.store_nothing(depsgraph)
            self._fail(error)
        if not depsgraph.scene.render.use_persistent_data:
            layer.close()
            del self._layers[depsgraph.view_layer.name]

    def _fail(self, error: Exception) -> None:
        import gnomon

        if isinstance(error, gnomon.Interrupted):
            return
        if not isinstance(error, gnomon.Error):
            traceback.print_exc()
        self.report({"ERROR"}, f"Gnomon: {error}")
        self.error_set(f"Gnomon: {error}")

    # Viewports.

    def view_update(self, context, depsgraph) -> None:
        if not self._loaded():
            return
        from .viewport import Viewport

        self._state("_viewport", lambda: Viewport(self)).update(context, depsgraph)

    def view_draw(self, context, depsgraph) -> None:
        viewport = getattr(self, "_viewport", None)
        if viewport is not None:
            viewport.draw(context, depsgraph)
