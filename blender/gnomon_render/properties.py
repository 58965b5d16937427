# SPDX-License-Identifier: Apache-2.0
"""The options of a scene, from the table of options of the program (options.json, which `gnomon_documents` writes)."""
from __future__ import annotations

import json
import os
import textwrap
from typing import Any

import bpy

TABLE: dict = {}
"""{option: {"kind", "fallback", "choices", "range", "help", "group"}}"""
with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "options.json"), encoding="utf-8") as _file:
    TABLE = json.load(_file)


def _help(option: str) -> str:
    return str(TABLE[option]["help"])


def _number(option: str, name: str, **more: Any):
    row = TABLE[option]
    low, high = row["range"]
    values: dict = {"name": name, "description": _help(option), "min": low, "max": high, **more}
    if row["kind"].startswith("integer"):
        values.setdefault("default", int(row["fallback"]) if row["fallback"].lstrip("-").isdigit() else int(low))
        values["min"], values["max"] = int(values["min"]), int(min(values["max"], 2**31 - 1))
        return bpy.props.IntProperty(**values)
    values.setdefault("default", float(row["fallback"] or 0))
    return bpy.props.FloatProperty(**values)


def _choice(option: str, name: str, only: tuple = ()):
    row = TABLE[option]
    words = [word for word in row["choices"].split("|") if not only or word in only]
    items = [(word, word.replace("-", " ").capitalize(), _meaning(row["help"], word)) for word in words]
    return bpy.props.EnumProperty(name=name, description=_help(option), items=items, default=row["fallback"])


def _meaning(text: str, word: str) -> str:
    """What the help says of one choice."""
    for part in text.replace(". ", "; ").split("; "):
        names, _, meaning = part.partition(":")
        if meaning and word in [each.strip() for each in names.split(",")]:
            return textwrap.shorten(meaning.strip(), 200)
    return ""


class GnomonSceneSettings(bpy.types.PropertyGroup):
    """Options of a scene."""

    adaptive: bpy.props.BoolProperty(name="Adaptive Samples", default=True, description=_help("samples"))   # type: ignore[valid-type]
    samples: _number("samples", "Samples", default=4)   # type: ignore[valid-type]
    filter: _choice("filter", "Pixel Filter")   # type: ignore[valid-type]
    max_depth: _number("max-depth", "Reflections and Refractions")   # type: ignore[valid-type]
    indirect: _choice("indirect", "Indirect Light", ("off", "visible"))   # type: ignore[valid-type]
    all_bounces: bpy.props.BoolProperty(name="All Bounces", default=True, description=_help("bounces"))   # type: ignore[valid-type]
    bounces: _number("bounces", "Bounces", default=4)   # type: ignore[valid-type]
    indirect_memory: _number("indirect-memory", "Irradiance Cache (MB)", default=64)   # type: ignore[valid-type]
    memory: _number("memory", "Memory (MB)")   # type: ignore[valid-type]
    shadow_culling: _choice("shadow-culling", "Shadow Culling", ("off", "certified"))   # type: ignore[valid-type]
    arithmetic: bpy.props.BoolProperty(name="Native Arithmetic", default=False, description=_help("isa"))   # type: ignore[valid-type]
    viewport_scale: bpy.props.IntProperty(   # type: ignore[valid-type]
        name="Viewport Pixel Size", min=1, max=8, default=2,
        description="sides of the viewport's first image in pixels of the screen; finer ones follow")


def render_options(settings, render) -> dict:
    """Members of gnomon.RenderOptions."""
    threads = render.threads if render.threads_mode == "FIXED" else 0
    return {
        "samples": "auto" if settings.adaptive else settings.samples,
        "filter": settings.filter,
        "max_depth": settings.max_depth,
        "indirect": settings.indirect,
        "bounces": "all" if settings.all_bounces else settings.bounces,
        "indirect_memory": settings.indirect_memory,
        "memory": settings.memory,
        "shadow_culling": settings.shadow_culling,
        "arithmetic": "native" if settings.arithmetic else "portable",
        "threads": threads,
        "tonemap": "none",
        "background": "transparent" if render.film_transparent else "environment",
    }
