# SPDX-License-Identifier: Apache-2.0
"""The renderer."""
from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Optional, Union

import numpy.typing as npt

from . import _gnomon
from ._camera import Camera, Matrix
from ._frame import Frame
from ._gnomon import InstanceId, LightId, MaterialId, NodeId, Scene
from ._options import RenderOptions
from ._parts import Light, Material

Progress = Callable[[str, float], Optional[bool]]
"""Called every few milliseconds with the stage of the work and how much of it is done, 0 to 1, from any thread but never
from two at once. False stops the work."""


@dataclass(slots=True, eq=False)
class Vertices:
    """The vertices of a deformed instance, instead of its mesh's."""

    positions: npt.ArrayLike
    """(n, 3): as many as the mesh has, in object space; of a skinned instance in world space."""
    normals: Optional[npt.ArrayLike] = None
    """(n, 3); None: computed from the positions if the mesh has normals."""


@dataclass(slots=True, eq=False)
class Closing:
    """Values when the camera's shutter closes, for motion blur (RenderOptions.shutter). Those that are handed over beside
    them are then the ones of its opening. A part without a value here stands still meanwhile."""

    transforms: Union[Mapping[NodeId, Matrix], Mapping[InstanceId, Matrix], None] = None
    """{node: matrix}, for nodes that get a transform."""
    vertices: Optional[Mapping[InstanceId, npt.ArrayLike]] = None
    """{instance: (n, 3)}, for instances that get vertices."""
    morph_weights: Optional[Mapping[InstanceId, npt.ArrayLike]] = None
    """{instance: weights}, for instances that get weights."""
    camera: Optional[Camera] = None
    """If the frame gets a camera."""
    lights: Optional[Mapping[LightId, Light]] = None
    """{light: values}, for lights that get values. Types stay what they are."""
    materials: Optional[Mapping[MaterialId, Material]] = None
    """{material: values}, for materials that get values. What is seen through, sides and textures stay what they are."""


class Renderer(_gnomon.Renderer):
    """Renders frames, and keeps what stays the same from frame to frame. A frame depends on the scene, what was handed over
    and the options alone: neither on the number of threads, nor on earlier frames.

        with gnomon.Renderer(size=(640, 480), layers=True) as renderer:
            frame = renderer.render(scene)

    Options are those of RenderOptions: as an object, by name, or both; names win.

    Threads: one thread at a time uses a renderer, and cancel() may be called from any. Any number of renderers may render
    at once in different threads, also of the same scene. Other threads of Python run while it renders."""

    def __init__(self, options: Optional[RenderOptions] = None, **changes: Any) -> None:
        """Raises UsageError if an option is out of range, and TypeError if there is no such option."""
        super().__init__(dataclasses.replace(options or RenderOptions(), **changes))

    def render(
        self,
        scene: Scene,
        frame: int = 1,
        *,
        time: Optional[float] = None,
        camera: Optional[Camera] = None,
        turn: float = 0.0,
        transforms: Union[Mapping[NodeId, Matrix], Mapping[InstanceId, Matrix], None] = None,
        visibility: Union[Mapping[NodeId, bool], Mapping[InstanceId, bool], None] = None,
        vertices: Optional[Mapping[InstanceId, Union[Vertices, npt.ArrayLike]]] = None,
        morph_weights: Optional[Mapping[InstanceId, npt.ArrayLike]] = None,
        lights: Optional[Mapping[LightId, Light]] = None,
        materials: Optional[Mapping[MaterialId, Material]] = None,
        released: Optional[Iterable[Union[NodeId, LightId, MaterialId]]] = None,
        closing: Optional[Closing] = None,
        indirect_ray_limit: int = 0,
        out: Optional[Mapping[str, npt.NDArray[Any]]] = None,
        progress: Optional[Progress] = None,
    ) -> Frame:
        """Takes over what changed since the frame before, and renders a frame.

        scene          another scene than before begins anew, unless only what may move or deform was added or removed
        frame          of the scene's clip, from 1
        time           seconds, instead of a frame's
        camera         None: the scene's camera that RenderOptions.camera names
        turn           radians by which the scene's camera has circled the scene
        transforms     {node: matrix}: (4, 4) or (3, 4), to the parent's space
        visibility     {node: bool}: of the node and everything below it
        vertices       {instance: (n, 3)}, or {instance: Vertices}
        morph_weights  {instance: weights}
        lights         {light: Light}
        materials      {material: Material}
        released       parts whose values end: what the scene says holds again
        closing        values of the shutter's closing, see Closing
        indirect_ray_limit  rays of indirect light in this frame; what is missing comes with later frames of the same
                       input, until Frame.complete. 0: no limit
        out            {layer: array}: layers that are also written into arrays of the caller's, (height, width[, channels])
                       of float32, float16, uint32 (ids), or uint8 (RGBA as the image is shown). '' is the image;
                       'normal.X' is one channel
        progress       see Progress

        Values stay in force until other ones are handed over, or until they are released. A value that equals the one in
        force costs a comparison. They hold while the shutter is open, unless `closing` has other ones.

        Raises UsageError if an id is not of this scene, a number is not finite or lengths disagree, and then nothing is
        taken over; MissingError if memory or a Vulkan device is missing; Interrupted after cancel(), or if progress
        returned False; KeyboardInterrupt on Ctrl-C; and what progress raises. The renderer can be used further."""
        return Frame(
            self._render(
                scene,
                frame=frame,
                time=time,
                camera=camera,
                turn=turn,
                transforms=transforms,
                visibility=visibility,
                vertices=vertices,
                morph_weights=morph_weights,
                lights=lights,
                materials=materials,
                released=released,
                closing=closing,
                indirect_ray_limit=indirect_ray_limit,
                out=out,
                progress=progress,
            )
        )

    def set_options(self, options: Optional[RenderOptions] = None, **changes: Any) -> None:
        """Other options for the frames that follow: those in force, or `options`, with the changes by name. What they do
        not bear on stays remembered.

        Raises UsageError if an option is out of range, or `interactive` differs."""
        self._set_options(dataclasses.replace(options or self.options, **changes))

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
