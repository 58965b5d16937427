# SPDX-License-Identifier: Apache-2.0
"""Scenes from arrays and from files, errors, and the types that the package declares."""
import ast
import copy
import dataclasses
import importlib
import inspect
import re
import shutil
import subprocess
import tempfile
import typing
import unittest
from pathlib import Path

import numpy as np

import gnomon
from support import EIGHT_TRIANGLES, OCTAHEDRON, PROGRAM, ROOT, SQUARE, TWO_TRIANGLES, make_room


class Building(unittest.TestCase):
    def render(self, build, **options):
        with gnomon.SceneBuilder() as builder:
            build(builder)
            builder.light(gnomon.Light(color=(20, 20, 20)), gnomon.translation(0, 0, 3))
            builder.camera(gnomon.Camera(transform=gnomon.translation(0, 0, 3), vertical_fov=0.6))
            scene = builder.finish()
        with gnomon.Renderer(size=(24, 24), exposure=0, indirect="off", threads=1, layers=True, **options) as renderer:
            return renderer.render(scene)

    def test_arrays_of_any_number_type_and_layout_give_the_same_image(self):
        first = None
        wide = np.zeros((8, 3))
        wide[::2] = SQUARE
        for positions, triangles in ((SQUARE, TWO_TRIANGLES), (SQUARE.astype(float), TWO_TRIANGLES.astype(np.int16)),
                                     (SQUARE.tolist(), TWO_TRIANGLES.tolist()), (np.asfortranarray(SQUARE), TWO_TRIANGLES),
                                     (wide[::2], TWO_TRIANGLES.astype(np.uint64)), (SQUARE[TWO_TRIANGLES.ravel()], None)):
            image = self.render(lambda b: b.instance(b.mesh(positions, triangles))).color
            first = image if first is None else first
            np.testing.assert_array_equal(image, first)

    def test_texture_coordinates_run_from_the_upper_left_corner(self):
        pixels = np.zeros((2, 2, 3), np.uint8)
        pixels[0, 0], pixels[0, 1], pixels[1, 0] = (255, 0, 0), (0, 255, 0), (0, 0, 255)

        def build(builder):
            texture = builder.texture(pixels, magnify="nearest", mipmaps=False, minify="nearest")
            paint = builder.material(gnomon.Material(model="unlit", base_color=(1, 1, 1), base_color_texture=texture))
            builder.instance(builder.mesh(SQUARE, TWO_TRIANGLES, uvs=[[0, 1], [1, 1], [1, 0], [0, 0]]), paint)

        image = self.render(build).color
        np.testing.assert_allclose(image[6, 6], [1, 0, 0], atol=1e-6)
        np.testing.assert_allclose(image[6, 18], [0, 1, 0], atol=1e-6)
        np.testing.assert_allclose(image[18, 6], [0, 0, 1], atol=1e-6)

    def test_a_texture_use_can_move_its_coordinates(self):
        pixels = np.array([[0, 255]], np.uint8)

        def build(builder, offset):
            use = gnomon.TextureUse(builder.texture(pixels, magnify="nearest", minify="nearest"), offset=(offset, 0))
            paint = builder.material(gnomon.Material(model="unlit", base_color=(1, 1, 1), base_color_texture=use))
            builder.instance(builder.mesh(SQUARE, TWO_TRIANGLES, uvs=[[0, 1], [1, 1], [1, 0], [0, 0]]), paint)

        plain, moved = (self.render(lambda b, o=o: build(b, o)).color for o in (0, 0.5))
        self.assertEqual((float(plain[12, 6, 0]), float(moved[12, 6, 0])), (0, 1))

    def test_parts_have_materials_of_their_own(self):
        def build(builder):
            red, green = (builder.material(gnomon.Material(model="unlit", base_color=c)) for c in ((1, 0, 0), (0, 1, 0)))
            builder.instance(builder.mesh(SQUARE, TWO_TRIANGLES, parts=[(red, 1), (green, 1)]))

        image = self.render(build).color
        np.testing.assert_array_equal(image[14, 18], [1, 0, 0])
        np.testing.assert_array_equal(image[10, 6], [0, 1, 0])

    def test_an_environment_lights_from_where_its_pixels_are(self):
        def build(builder, row):
            sky = np.zeros((8, 16, 3))
            if row is not None:
                sky[row] = 1
            builder.environment(sky)
            tilted = gnomon.rotation((1, 0, 0), -0.6)   # its front looks up
            builder.instance(builder.mesh(SQUARE, TWO_TRIANGLES), None, tilted)

        dark, above, below = (float(self.render(lambda b, r=r: build(b, r)).direct[12, 12, 0]) for r in (None, 0, 7))
        self.assertGreater(above, 1.1 * dark)
        self.assertAlmostEqual(below, dark, places=5)

    def test_lights_of_every_kind_light(self):
        for add in (lambda b: b.light(gnomon.Light(type="directional", color=(3, 3, 3))),
                    lambda b: b.light(gnomon.Light(type="spot", color=(9, 9, 9)), gnomon.translation(0, 0, 2)),
                    lambda b: b.area_light(gnomon.AreaLight(width=0.2, radiance=(50, 50, 50)), gnomon.translation(1, 0, 2)),
                    lambda b: b.area_light(gnomon.AreaLight(shape="sphere", width=0.2), gnomon.translation(0, 1, 1))):
            with gnomon.SceneBuilder() as builder:
                builder.instance(builder.mesh(SQUARE, TWO_TRIANGLES))
                add(builder)
                builder.camera(gnomon.Camera(transform=gnomon.translation(0, 0, 3), vertical_fov=0.6))
                with gnomon.Renderer(size=(8, 8), exposure=0, indirect="off", threads=1) as renderer:
                    self.assertGreater(float(renderer.render(builder.finish()).color[4, 4].min()), 0)

    def test_morph_targets_and_skins_deform(self):
        with gnomon.SceneBuilder() as builder:
            mesh = builder.mesh(SQUARE, TWO_TRIANGLES, morph_targets=[np.full((4, 3), [0, 0, 1.0]), {"positions": 0 * SQUARE}])
            morphed = builder.instance(mesh, mobility="may_deform")
            builder.light(gnomon.Light(), gnomon.translation(0, 0, 5))
            builder.camera(gnomon.Camera(transform=gnomon.translation(0, 0, 5)))
            scene = builder.finish()
        with gnomon.Renderer(size=(9, 9), layers=True, indirect="off", threads=1) as renderer:
            self.assertAlmostEqual(float(renderer.render(scene).depth[4, 4]), 5, places=5)
            frame = renderer.render(scene, morph_weights={morphed: [0.5, 1]})
            self.assertAlmostEqual(float(frame.depth[4, 4]), 4.5, places=5)

        with gnomon.SceneBuilder() as builder:
            joint = builder.node(mobility="may_move")
            skin = builder.skin([joint], [np.eye(4)])
            skinned = builder.mesh(SQUARE, TWO_TRIANGLES, joints=np.zeros((4, 4), int), weights=[[1, 0, 0, 0]] * 4)
            builder.instance(skinned, skin=skin)
            builder.light(gnomon.Light(), gnomon.translation(0, 0, 5))
            builder.camera(gnomon.Camera(transform=gnomon.translation(0, 0, 5)))
            scene = builder.finish()
        with gnomon.Renderer(size=(9, 9), layers=True, indirect="off", threads=1) as renderer:
            frame = renderer.render(scene, transforms={joint: gnomon.translation(0, 0, 2)})
            self.assertAlmostEqual(float(frame.depth[4, 4]), 3, places=5)

    def test_a_scene_can_be_opened_changed_and_finished_again(self):
        room = make_room()
        with gnomon.SceneBuilder(room.scene) as builder:
            builder.set_material(room.paint, gnomon.Material(base_color=(0, 1, 0)))
            builder.set_transform(room.ball, gnomon.translation(1, 0, 0))
            builder.remove(room.light)
            scene = builder.finish()
        self.assertEqual(scene.material(room.paint).base_color, (0, 1, 0))
        self.assertEqual(scene.transform(room.ball)[0, 3], 1)
        self.assertEqual((len(scene.lights), len(room.scene.lights)), (0, 1))
        self.assertEqual(scene.find_instance("ball"), room.ball)
        self.assertIsNone(scene.find_instance("nothing"))
        self.assertEqual((scene.name(room.wall), scene.mobility(room.ball)), ("wall", "may_deform"))

    def test_values_come_back_as_they_went_in(self):
        layers = gnomon.MaterialLayers(clearcoat=0.5, sheen_color=(0.1, 0.2, 0.3))
        with gnomon.SceneBuilder() as builder:
            texture = builder.texture(np.zeros((2, 2), np.uint8))
            material = gnomon.Material("m", base_color=(0.1, 0.2, 0.3), roughness=0.7, layers=layers,
                                       normal_texture=gnomon.TextureUse(texture, rotation=0.5))
            light = gnomon.Light("l", "spot", (1, 2, 3), outer_angle=0.5, range=9)
            camera = gnomon.Camera("c", gnomon.translation(1, 2, 3), intrinsics=gnomon.Intrinsics(9, 8, 7, 6, (32, 24)))
            m, l, c = builder.material(material), builder.light(light), builder.camera(camera)
            scene = builder.finish()
        self.assertEqual(scene.material(m), material)
        self.assertEqual(scene.light(l), light)
        self.assertEqual(scene.camera(c).intrinsics, camera.intrinsics)
        np.testing.assert_array_equal(scene.camera(c).transform, camera.transform)


class Errors(unittest.TestCase):
    def test_a_file_error_has_file_place_and_problem(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "broken.gltf")
            file.write_text('{"asset": {"version": "2.0"},\n "scenes": [,]}')
            for error in (gnomon.InputError, gnomon.Error, ValueError):
                with self.assertRaises(error) as raised:
                    gnomon.load(file)
            self.assertEqual(raised.exception.file, str(file))
            self.assertTrue(raised.exception.place and raised.exception.problem)
            self.assertIn(raised.exception.place, str(raised.exception))
            with self.assertRaises(gnomon.InputError) as raised:
                gnomon.load(str(file) + ".glb")
            self.assertIn("No such file", raised.exception.problem)
        with self.assertRaises(gnomon.UsageError):
            gnomon.load("builtin:nothing")

    def test_wrong_arrays_are_refused_with_their_shape(self):
        builder = gnomon.SceneBuilder()
        mesh = builder.mesh(SQUARE, TWO_TRIANGLES)
        cases = (
            (lambda: builder.mesh(SQUARE[:, :2], TWO_TRIANGLES), gnomon.UsageError, "(4, 2); expected (n, 3)"),
            (lambda: builder.mesh(SQUARE, [[0, 1, 4]]), gnomon.UsageError, "4"),
            (lambda: builder.mesh(SQUARE, [[0, 1, -1]]), gnomon.UsageError, "-1"),
            (lambda: builder.mesh(SQUARE, TWO_TRIANGLES * 1.0), TypeError, "integers"),
            (lambda: builder.mesh("square", TWO_TRIANGLES), TypeError, "positions"),
            (lambda: builder.mesh(SQUARE, TWO_TRIANGLES, normals=SQUARE[:3]), gnomon.UsageError, ""),
            (lambda: builder.mesh(SQUARE * np.nan, TWO_TRIANGLES), gnomon.UsageError, ""),
            (lambda: builder.mesh(SQUARE, TWO_TRIANGLES, colours=[]), TypeError, "colours"),
            (lambda: builder.mesh(None), TypeError, "positions"),
            (lambda: builder.instance(mesh, transform=np.eye(3)), gnomon.UsageError, "(3, 3)"),
            (lambda: builder.instance(mesh, transform=np.full((4, 4), np.inf)), gnomon.UsageError, ""),
            (lambda: builder.instance(mesh, mobility="wobbles"), gnomon.UsageError, "wobbles"),
            (lambda: builder.instance(mesh, mesh), TypeError, "MaterialId"),
            (lambda: builder.texture(np.zeros((2, 2))), TypeError, "uint8"),
            (lambda: builder.texture(b"no image"), gnomon.InputError, ""),
            (lambda: builder.material(gnomon.Material(roughness="rough")), TypeError, "Material.roughness"),
            (lambda: builder.material(gnomon.Material(base_color=(1, 2))), gnomon.UsageError, "Material.base_color"),
            (lambda: builder.material(gnomon.Light()), TypeError, "Material"),
            (lambda: builder.environment(np.zeros((2, 2))), gnomon.UsageError, "(2, 2)"),
            (lambda: builder.remove(mesh) or builder.remove(mesh), gnomon.UsageError, ""),
            (lambda: builder.remove(7), TypeError, ""),
            (lambda: gnomon.Material(colour=1), TypeError, "colour"),
        )
        for call, error, words in cases:
            with self.assertRaises(error) as raised:
                call()
            self.assertIn(words, str(raised.exception))
        builder.finish()   # as if none of it had happened

    def test_options_out_of_range_are_refused(self):
        for options, error, words in (({"size": (0, 5)}, gnomon.UsageError, ""), ({"samples": "many"}, TypeError, "samples"),
                                      ({"tonemap": "nice"}, gnomon.UsageError, "'agx'"), ({"layers": 1}, TypeError, "layers"),
                                      ({"threads": -1}, gnomon.UsageError, ""), ({"breadth": 1}, TypeError, "breadth"),
                                      ({"size": "8x8"}, TypeError, "size"), ({"samples": 2**40}, gnomon.UsageError, "")):
            with self.assertRaises(error) as raised:
                gnomon.Renderer(**options)
            self.assertIn(words, str(raised.exception))

    def test_a_wrong_frame_changes_nothing(self):
        room, other = make_room(), make_room()
        with gnomon.Renderer(size=(16, 12), threads=1, exposure=0) as renderer:
            before = renderer.render(room.scene).color.copy()
            for input, error in (({"transforms": {other.ball: np.eye(4)}}, gnomon.UsageError),
                                 ({"transforms": {room.ball: np.full((4, 4), np.nan)}}, gnomon.UsageError),
                                 ({"transforms": {room.light: np.eye(4)}}, TypeError),
                                 ({"transforms": [np.eye(4)]}, TypeError),
                                 ({"vertices": {room.ball: OCTAHEDRON[:5]}}, gnomon.UsageError),
                                 ({"visibility": {room.ball: 1}}, TypeError), ({"frame": 99}, gnomon.UsageError),
                                 ({"time": float("nan")}, gnomon.UsageError), ({"lights": {room.light: 3}}, TypeError),
                                 ({"progress": 3}, TypeError), ({"smell": 3}, TypeError)):
                with self.assertRaises(error):
                    renderer.render(room.scene, **{"transforms": {room.ball: gnomon.translation(0, 1, 0)}, **input})
            np.testing.assert_array_equal(renderer.render(room.scene).color, before)

    def test_closed_things_are_refused(self):
        room = make_room()
        with gnomon.Renderer(size=(8, 6)) as renderer, room.builder as builder:
            pass
        for call in (lambda: renderer.render(room.scene), lambda: renderer.options, builder.finish, renderer.report):
            with self.assertRaises(gnomon.UsageError) as raised:
                call()
            self.assertIn("closed", str(raised.exception))
        renderer.close()
        builder.close()


class Ids(unittest.TestCase):
    def test_ids_are_compared_and_hashed_by_their_part(self):
        room, other = make_room(), make_room()
        self.assertEqual(room.ball, room.scene.find_instance("ball"))
        self.assertNotEqual(room.ball, other.ball)
        self.assertNotEqual(room.ball, room.light)
        self.assertEqual(len({room.ball, room.wall, room.scene.instances[1]}), 2)
        self.assertIsInstance(room.ball, gnomon.NodeId)
        self.assertEqual(copy.copy(room.scene.instances), room.scene.instances)


def parameters_of(function: ast.FunctionDef):
    """Names, kinds and defaults, as inspect has them."""
    a = function.args
    positional = [arg.arg for arg in a.args]
    defaults = [None] * (len(positional) - len(a.defaults)) + [ast.unparse(d) for d in a.defaults]
    named = [(arg.arg, ast.unparse(d) if d else None) for arg, d in zip(a.kwonlyargs, a.kw_defaults)]
    return list(zip(positional, defaults)), named, bool(a.vararg)


def parameters_at_run_time(function):
    positional, named, many = [], [], False
    for p in inspect.signature(function).parameters.values():
        entry = (p.name, None if p.default is p.empty else repr(p.default))
        if p.kind == p.KEYWORD_ONLY:
            named.append(entry)
        elif p.kind == p.VAR_POSITIONAL:
            many = True
        else:
            positional.append(entry)
    return positional, named, many


def differences(stub: ast.Module, module) -> list[str]:
    """What a stub says otherwise than the module does, in names and in signatures."""
    found = []

    def compare(name, functions, runtime):
        # Functions of which only **kwargs is known to Python have no signature.
        if not getattr(runtime, "__text_signature__", None):
            return
        if any(parameters_of(f) == parameters_at_run_time(runtime) for f in functions):
            return
        if len(functions) == 1:
            found.append(f"{name}: {parameters_of(functions[0])}, but {parameters_at_run_time(runtime)}")

    def members(body):
        all_of = {}
        for statement in body:
            if isinstance(statement, (ast.FunctionDef, ast.ClassDef)):
                all_of.setdefault(statement.name, []).append(statement)
        return all_of

    declared = members(stub.body)
    there = {n for n in vars(module) if not n.startswith("__")}
    found += [f"{n} is not in the stub" for n in sorted(there - set(declared))]
    found += [f"{n} is not in the module" for n in sorted(set(declared) - there - {"_Id"})]
    for name, nodes in declared.items():
        if name not in there:
            continue
        if isinstance(nodes[0], ast.FunctionDef):
            compare(name, nodes, getattr(module, name))
            continue
        inner = members(nodes[0].body)
        own = {n for n in vars(getattr(module, name)) if not n.startswith("__") and n != "_pybind11_conduit_v1_"}
        if nodes[0].bases or name == "_Id":
            own -= set()
        found += [f"{name}.{n} is not in the stub" for n in sorted(own - set(inner))]
        found += [f"{name}.{n} is not in the module" for n in sorted(set(inner) - own) if not n.startswith("__")]
        for member, functions in inner.items():
            if member in own:
                compare(f"{name}.{member}", functions, vars(getattr(module, name))[member])
    return found


class Types(unittest.TestCase):
    def stub(self) -> str:
        return Path(gnomon.__file__).with_name("_gnomon.pyi").read_text()

    def test_the_stub_declares_what_the_module_has(self):
        module = importlib.import_module("gnomon._gnomon")
        self.assertEqual(differences(ast.parse(self.stub()), module), [])

    def test_the_comparison_finds_differences(self):
        module = importlib.import_module("gnomon._gnomon")
        for old, new in (("def find_node(self, name: str)", "def find_nod(self, name: str)"),
                         ("lights: int = 16) -> Scene", "lights: int = 8) -> Scene"),
                         ("def improve(self, seconds: float)", "def improve(self, second: float)"),
                         ("def instruction_set() -> str: ...", ""), ("animation: Union[str, int, None] = None,", "")):
            self.assertIn(old, self.stub())
            self.assertNotEqual(differences(ast.parse(self.stub().replace(old, new)), module), [], old)

    def test_the_package_is_marked_as_typed_and_all_names_are_there(self):
        self.assertTrue(Path(gnomon.__file__).with_name("py.typed").exists())
        for name in gnomon.__all__:
            self.assertTrue(hasattr(gnomon, name), name)

    def test_everything_public_is_documented(self):
        for name in gnomon.__all__:
            thing = getattr(gnomon, name)
            if inspect.isclass(thing) or inspect.isroutine(thing):
                self.assertTrue(thing.__doc__, name)
            if inspect.isclass(thing):
                for member, value in vars(thing).items():
                    if not member.startswith("_") and not isinstance(value, (str, int, float)) and \
                            type(value).__name__ != "member_descriptor":
                        self.assertTrue(getattr(value, "__doc__", None), f"{name}.{member}")

    def test_defaults_are_the_librarys(self):
        for name, expected in importlib.import_module("gnomon._gnomon")._defaults().items():
            own = getattr(gnomon, name)()
            for field in dataclasses.fields(own):
                a, b = getattr(own, field.name), getattr(expected, field.name)
                if field.name == "transform":   # None stands for the identity
                    a, b = np.eye(4).tolist(), b.tolist()
                self.assertEqual(a, b, f"{name}.{field.name}")

    def test_choices_are_the_command_lines(self):
        if not PROGRAM:
            self.skipTest("GNOMON_PROGRAM is not set")
        text = subprocess.run([PROGRAM, "render", "--help"], capture_output=True, text=True, check=True).stdout
        hints = typing.get_type_hints(gnomon.RenderOptions)
        for field in ("tonemap", "shadow_culling", "indirect_on", "accelerator"):
            match = re.search(rf"^ +--{field.replace('_', '-')} ([a-z0-9|]+)$", text, re.MULTILINE)
            self.assertTrue(match, field)
            self.assertEqual(list(typing.get_args(hints[field])), match[1].split("|"), field)

    def test_the_package_and_the_examples_are_typed_strictly(self):
        mypy = shutil.which("mypy", path="/usr/bin:/usr/local/bin")
        if not mypy:
            self.skipTest("mypy is not installed")
        with tempfile.TemporaryDirectory() as cache:
            examples = sorted(str(f) for f in (ROOT / "examples/python").glob("*.py"))
            result = subprocess.run([mypy, "--strict", "--cache-dir", cache, *examples], capture_output=True, text=True,
                                    env={"MYPYPATH": str(Path(gnomon.__file__).parents[1]), "PATH": "/usr/bin:/bin"})
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)


if __name__ == "__main__":
    unittest.main()
