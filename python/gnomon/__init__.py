# SPDX-License-Identifier: Apache-2.0
"""Gnomon lights animated 3D scenes, and recomputes only what changed.

    import gnomon

    scene = gnomon.load("kitchen.glb")
    with gnomon.Renderer(size=(640, 480), layers=True) as renderer:
        frame = renderer.render(scene, time=1.5)
    frame.write("kitchen.png")
    print(frame.depth.min())      # metres; numpy, without a copy

Lengths are metres, angles radians, times seconds; colours are linear, with Rec. 709 primaries. Images have the same bytes
on every processor, for any number of threads.
"""
from ._camera import Camera, Intrinsics, Matrix
from ._errors import Error, InputError, InternalError, Interrupted, MissingError, UsageError
from ._frame import Frame
from ._gnomon import (
    CameraId,
    InstanceId,
    LightId,
    MaterialId,
    MeshId,
    NodeId,
    Scene,
    SceneBuilder,
    SkinId,
    TextureId,
    __version__,
    compare,
    compose,
    instruction_set,
    inverse,
    load,
    look_at,
    rotation,
    scaling,
    translation,
)
from ._options import ReferenceLightOptions, RenderOptions
from ._parts import (
    AnimationInfo,
    AreaLight,
    CompareResult,
    FrameReport,
    Light,
    Material,
    MaterialLayers,
    Pick,
    SceneInfo,
    TextureUse,
)
from ._renderer import Closing, Progress, Renderer, Vertices

__all__ = [
    "AnimationInfo", "AreaLight", "Camera", "CameraId", "Closing", "CompareResult", "Error", "Frame", "FrameReport", "InputError",
    "InstanceId", "InternalError", "Interrupted", "Intrinsics", "Light", "LightId", "Material", "MaterialId",
    "MaterialLayers", "Matrix", "MeshId", "MissingError", "NodeId", "Pick", "Progress", "ReferenceLightOptions",
    "RenderOptions", "Renderer", "Scene", "SceneBuilder", "SceneInfo", "SkinId", "TextureId", "TextureUse", "UsageError",
    "Vertices", "__version__", "compare", "compose", "instruction_set", "inverse", "load", "look_at", "rotation", "scaling", "translation",
]
