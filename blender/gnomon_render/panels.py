# SPDX-License-Identifier: Apache-2.0
"""Panels of the properties editor."""
from __future__ import annotations

import bpy

from .engine import ENGINE

_NOT_OURS = {
    # what the engine does not have
    "RENDER_PT_simplify", "RENDER_PT_freestyle", "RENDER_PT_gpencil", "VIEWLAYER_PT_freestyle", "RENDER_PT_eevee",
    "DATA_PT_EEVEE_light", "VIEWLAYER_PT_eevee_layer_passes", "VIEWLAYER_PT_layer_passes",
}


class _Panel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"

    @classmethod
    def poll(cls, context) -> bool:
        return context.engine == ENGINE

    def column(self):
        """The panel's layout: labels to the left of values, which are not animated."""
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        return self.layout


class GNOMON_RENDER_PT_sampling(_Panel, bpy.types.Panel):
    bl_context = "render"
    bl_label = "Sampling"

    def draw(self, context) -> None:
        layout, settings = self.column(), context.scene.gnomon
        layout.prop(settings, "adaptive")
        row = layout.row()
        row.active = not settings.adaptive
        row.prop(settings, "samples")
        layout.prop(settings, "filter")
        layout.prop(settings, "viewport_scale")


class GNOMON_RENDER_PT_light(_Panel, bpy.types.Panel):
    bl_context = "render"
    bl_label = "Light"

    def draw(self, context) -> None:
        layout, settings = self.column(), context.scene.gnomon
        layout.prop(settings, "indirect")
        column = layout.column()
        column.active = settings.indirect == "visible"
        column.prop(settings, "all_bounces")
        row = column.row()
        row.active = not settings.all_bounces
        row.prop(settings, "bounces")
        layout.prop(settings, "max_depth")


class GNOMON_RENDER_PT_motion_blur(_Panel, bpy.types.Panel):
    bl_context = "render"
    bl_label = "Motion Blur"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context) -> None:
        self.layout.prop(context.scene.render, "use_motion_blur", text="")

    def draw(self, context) -> None:
        layout, render = self.column(), context.scene.render
        layout.active = render.use_motion_blur
        layout.prop(render, "motion_blur_shutter")


class GNOMON_RENDER_PT_background(_Panel, bpy.types.Panel):
    bl_context = "render"
    bl_label = "Background"

    def draw(self, context) -> None:
        self.column().prop(context.scene.render, "film_transparent", text="Transparent")


class GNOMON_RENDER_PT_performance(_Panel, bpy.types.Panel):
    bl_context = "render"
    bl_label = "Performance"

    def draw(self, context) -> None:
        layout, settings, render = self.column(), context.scene.gnomon, context.scene.render
        layout.prop(render, "use_persistent_data", text="Persistent Data")
        layout.prop(render, "threads_mode")
        if render.threads_mode == "FIXED":
            layout.prop(render, "threads")
        layout.prop(settings, "indirect_memory")
        layout.prop(settings, "memory")
        layout.prop(settings, "shadow_culling")
        layout.prop(settings, "arithmetic")


class GNOMON_VIEWLAYER_PT_passes(_Panel, bpy.types.Panel):
    bl_context = "view_layer"
    bl_label = "Passes"

    def draw(self, context) -> None:
        layout = self.column()
        column = layout.column(heading="Data")
        for name in ("use_pass_z", "use_pass_normal", "use_pass_vector", "use_pass_object_index"):
            column.prop(context.view_layer, name)
        column = layout.column(heading="Light")
        for name in ("use_pass_diffuse_color", "use_pass_shadow"):
            column.prop(context.view_layer, name)


CLASSES = (GNOMON_RENDER_PT_sampling, GNOMON_RENDER_PT_light, GNOMON_RENDER_PT_motion_blur, GNOMON_RENDER_PT_background,
           GNOMON_RENDER_PT_performance, GNOMON_VIEWLAYER_PT_passes)


def _shared_panels() -> list:
    """Blender's own panels that suit any engine: those that the built-in one has, and Cycles' panels of lights, materials
    and worlds, whose settings are Blender's."""
    found = []
    for name in dir(bpy.types):
        panel = getattr(bpy.types, name)
        engines = getattr(panel, "COMPAT_ENGINES", None)
        if engines is None or name in _NOT_OURS:
            continue
        if "BLENDER_RENDER" in engines or name in {"EEVEE_MATERIAL_PT_context_material", "EEVEE_MATERIAL_PT_surface",
                                                   "EEVEE_WORLD_PT_surface", "DATA_PT_light", "DATA_PT_spot"}:
            found.append(panel)
    return found


def share() -> None:
    for panel in _shared_panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def unshare() -> None:
    for panel in _shared_panels():
        panel.COMPAT_ENGINES.discard(ENGINE)
