# SPDX-License-Identifier: Apache-2.0
"""The layer check finds every kind of forbidden include, and nothing in a tree without one."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

k_tool = pathlib.Path(__file__).resolve().parents[2] / "tools" / "check_layers.py"


def check(files: dict[str, str]) -> subprocess.CompletedProcess:
    with tempfile.TemporaryDirectory() as folder:
        for name, included in files.items():
            path = pathlib.Path(folder) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(f'// text\n#include "{included}"\n#include <vector>\n')
        return subprocess.run([sys.executable, k_tool, folder], capture_output=True, text=True)


class CheckLayers(unittest.TestCase):
    def test_allowed(self):
        for name, included in [
            ("src/scene/a.cpp", "base/b.h"), ("src/scene/a.cpp", "scene/c.h"), ("src/base/a.h", "gnomon/types.h"),
            ("src/trace/a.cpp", "shadow_culling/certified/b.h"), ("cli/subcommand_view.cpp", "viewer/b.h"),
            ("cli/subcommand_render.cpp", "cli/subcommands.h"), ("cli/subcommand_render.cpp", "options/b.h"),
            ("src/irradiance_cache/vulkan/a.cpp", "ray/vulkan/b.h"), ("bench/core/a.cpp", "ray/embree/b.h"), ("examples/a.cpp", "gnomon/gnomon.h"),
            ("examples/a.cpp", "shapes.h"),
            ("include/gnomon/a.h", "gnomon/b.h"), ("viewer/a.cpp", "viewer/b.h"), ("viewer/a.cpp", "base/b.h"),
            ("viewer/a.cpp", "options/b.h"), ("viewer/a.cpp", "io/file/b.h"), ("viewer/a.cpp", "gnomon/b.h"),
            ("cli/output.cpp", "io/file/b.h"), ("cli/subcommand_bench_trace.cpp", "scene/b.h"),
            ("cli/subcommand_bench_trace.cpp", "bench/core/b.h"),
            ("python/bindings/a.cpp", "gnomon/b.h"), ("python/bindings/a.cpp", "python/bindings/b.h"),
        ]:
            with self.subTest(name=name, included=included):
                result = check({name: included})
                self.assertEqual(result.returncode, 0, result.stdout + result.stderr)

    def test_forbidden(self):
        for name, included in [
            ("python/bindings/a.cpp", "base/b.h"), ("python/bindings/a.cpp", "options/b.h"),
            ("src/base/a.cpp", "scene/b.h"), ("src/io/a.cpp", "ray/b.h"), ("src/ray/a.cpp", "io/b.h"),
            ("src/vk/a.cpp", "scene/b.h"), ("src/scene/a.cpp", "trace/b.h"), ("src/frame/a.cpp", "api/b.h"),
            ("src/ray/a.cpp", "ray/vulkan/b.h"), ("src/frame/a.cpp", "viewer/b.h"), ("bench/core/a.cpp", "cli/b.h"),
            ("src/shadow_culling/a.cpp", "light_quadtree/b.h"), ("src/light_quadtree/a.cpp", "shadow_culling/b.h"),
            ("src/shadow_culling/nah2009/a.cpp", "irradiance_cache/b.h"), ("src/raster/a.cpp", "trace/b.h"),
            ("cli/subcommand_render.cpp", "trace/b.h"), ("cli/subcommand_info_text.cpp", "scene/b.h"),
            ("examples/a.cpp", "scene/b.h"), ("include/gnomon/a.h", "base/b.h"), ("src/scene/a.cpp", "b.h"),
            ("src/scene/a.cpp", "../base/b.h"), ("src/unheard_of/a.cpp", "base/b.h"), ("src/base/a.cpp", "unheard_of/b.h"),
        ]:
            with self.subTest(name=name, included=included):
                result = check({"src/base/fine.cpp": "gnomon/types.h", name: included})
                self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
                self.assertIn(f"{name}:2: ", result.stdout)

    # The viewer and the subcommands other than benches use the public interface: what they lack is missing from it.
    def test_viewer_and_subcommands_use_the_public_interface(self):
        users = ["viewer/session.cpp", "viewer/session.h", "viewer/deep/a.cpp", "cli/subcommand_view.cpp",
                 "cli/subcommand_devices.cpp", "cli/subcommand_render.cpp", "cli/signals.h", "cli/new.cpp"]
        for name in users:
            for included in ["frame/frame_engine.h", "scene/scene.h", "api/scene_access.h", "video/encoder.h",
                             "vk/instance.h", "io/image/image_file.h", "image/tone_map.h", "bench/core/a.h"]:
                with self.subTest(name=name, included=included):
                    result = check({name: included})
                    self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
                    self.assertIn(f"{name}:2: ", result.stdout)
                    self.assertIn("include/gnomon", result.stdout)
        result = check({"cli/subcommand_render.cpp": "viewer/viewer.h"})
        self.assertEqual(result.returncode, 1, "the viewer belongs to its subcommand")

    def test_the_table_names_what_is_there(self):
        root = k_tool.parents[1]
        sys.dont_write_bytecode = True
        sys.path.insert(0, str(k_tool.parent))
        import check_layers
        named = set(check_layers.k_may_include)
        folders = {path.name for path in (root / "src").iterdir() if path.is_dir()} | set(check_layers.k_beside_src)
        self.assertEqual({name for name in named if "/" not in name}, folders)
        for name in named | set().union(*check_layers.k_may_include.values()):
            self.assertTrue((root / "src" / name).is_dir() or name in check_layers.k_beside_src, name)
        self.assertTrue((root / check_layers.k_opens_viewer).is_file())
        for top, public in [("viewer", "session.cpp"), ("cli", "subcommand_render.cpp")]:
            files = {path.relative_to(root).as_posix() for path in (root / top).iterdir()}
            self.assertIn(f"{top}/{public}", files)
            self.assertTrue(check_layers.k_public_only.fullmatch(f"{top}/{public}"))
        benches = [path for path in (root / "cli").glob("subcommand_bench_*.cpp")]
        self.assertTrue(benches)
        for path in benches:
            self.assertFalse(check_layers.k_public_only.fullmatch(path.relative_to(root).as_posix()))

    def test_empty_tree_is_a_fault(self):
        self.assertEqual(check({}).returncode, 1)


if __name__ == "__main__":
    unittest.main()
