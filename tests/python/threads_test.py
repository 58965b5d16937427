# SPDX-License-Identifier: Apache-2.0
"""Threads of Python, progress, and work that is stopped: by a signal, by cancel(), by a callback, at the end."""
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import traceback
import unittest
from pathlib import Path

import numpy as np

import gnomon
from support import make_room

# Long enough to be stopped in its midst: many paths per pixel.
LONG = {"size": (320, 240), "reference": gnomon.ReferenceLightOptions(spp=100_000, bounces=2), "threads": 2}


def render_in_child(queue):
    try:
        room = make_room()
        queue.put(gnomon.Renderer(size=(8, 6), threads=1).render(room.scene).size)
    except gnomon.UsageError as error:
        queue.put(str(error))


class Threads(unittest.TestCase):
    def test_two_renderers_in_two_threads_give_the_same_bytes_as_one(self):
        room = make_room()
        places = [gnomon.compose(gnomon.translation(0.1 * i, 0, 0), gnomon.scaling(0.3)) for i in range(6)]

        def render_all(into):
            with gnomon.Renderer(size=(48, 36), exposure=0, threads=1) as renderer:
                into += [renderer.render(room.scene, transforms={room.ball: place}).color.copy() for place in places]

        alone, one, two = [], [], []
        render_all(alone)
        threads = [threading.Thread(target=render_all, args=(into,)) for into in (one, two)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for a, b, c in zip(alone, one, two, strict=True):
            np.testing.assert_array_equal(a, b)
            np.testing.assert_array_equal(a, c)

    def test_other_threads_run_while_a_frame_is_rendered(self):
        room, rendering, counted = make_room(), threading.Event(), []
        renderer = gnomon.Renderer(**LONG)

        def count():
            rendering.wait(30)
            for i in range(1000):
                counted.append(i)
            renderer.cancel()

        thread = threading.Thread(target=count)
        thread.start()
        with self.assertRaises(gnomon.Interrupted):
            renderer.render(room.scene, progress=lambda stage, done: rendering.set())
        thread.join()
        self.assertEqual(len(counted), 1000)

    def test_one_renderer_refuses_a_second_thread(self):
        room, rendering, refused = make_room(), threading.Event(), []
        renderer = gnomon.Renderer(**LONG)

        def disturb():
            rendering.wait(30)
            for call in (lambda: renderer.render(room.scene), lambda: renderer.set_options(exposure=1), renderer.forget):
                try:
                    call()
                except gnomon.UsageError as error:
                    refused.append(str(error))
            renderer.cancel()

        thread = threading.Thread(target=disturb)
        thread.start()
        with self.assertRaises(gnomon.Interrupted):
            renderer.render(room.scene, progress=lambda stage, done: rendering.set())
        thread.join()
        self.assertEqual(len(refused), 3)

    def test_a_renderer_that_another_thread_closes_stops(self):
        room, rendering = make_room(), threading.Event()
        renderer = gnomon.Renderer(**LONG)
        thread = threading.Thread(target=lambda: (rendering.wait(30), renderer.close()))
        thread.start()
        with self.assertRaises(gnomon.Interrupted):
            renderer.render(room.scene, progress=lambda stage, done: rendering.set())
        thread.join()

    def test_a_callback_may_use_another_renderer(self):
        room, sizes = make_room(), []
        with gnomon.Renderer(size=(48, 36), threads=1) as outer, gnomon.Renderer(size=(8, 6), threads=1) as inner:
            def progress(stage, done):
                if not sizes:
                    sizes.append(inner.render(room.scene).size)

            outer.render(room.scene, progress=progress)
        self.assertEqual(sizes, [(8, 6)])


class Progress(unittest.TestCase):
    def test_progress_has_stages_and_fractions(self):
        steps = []
        gnomon.load("builtin:cornell", progress=lambda stage, done: steps.append((stage, done)))
        with gnomon.Renderer(size=(160, 120), threads=1) as renderer:
            renderer.render(make_room().scene, progress=lambda stage, done: steps.append((stage, done)))
        self.assertTrue(steps)
        for stage, done in steps:
            self.assertIsInstance(stage, str)
            self.assertTrue(0 <= done <= 1)

    def test_false_stops_and_the_next_frame_is_as_if_never_asked(self):
        room = make_room()
        with gnomon.Renderer(size=(48, 36), exposure=0, threads=1) as renderer:
            with self.assertRaises(gnomon.Interrupted):
                renderer.render(room.scene, progress=lambda stage, done: False)
            frame = renderer.render(room.scene, progress=lambda stage, done: None)
        with gnomon.Renderer(size=(48, 36), exposure=0, threads=1) as fresh:
            np.testing.assert_array_equal(frame.color, fresh.render(room.scene).color)
        with self.assertRaises(gnomon.Interrupted):
            gnomon.load("builtin:kinetic", progress=lambda stage, done: False)

    def test_what_a_callback_raises_comes_out(self):
        def fail(stage, done):
            raise LookupError(stage)

        with gnomon.Renderer(size=(48, 36)) as renderer:
            try:
                renderer.render(make_room().scene, progress=fail)
            except LookupError as error:
                self.assertTrue(error.args[0])
                self.assertIn("fail", [frame.name for frame in traceback.extract_tb(error.__traceback__)])
            else:
                self.fail("nothing was raised")


class Signals(unittest.TestCase):
    def test_ctrl_c_interrupts_a_frame_and_the_renderer_goes_on(self):
        room, sent = make_room(), []

        def interrupt(stage, done):
            if not sent:
                sent.append(stage)
                os.kill(os.getpid(), signal.SIGINT)

        with gnomon.Renderer(**LONG) as renderer:
            with self.assertRaises(KeyboardInterrupt):
                renderer.render(room.scene, progress=interrupt)
            renderer.set_options(reference=None, size=(8, 6))
            self.assertEqual(renderer.render(room.scene).size, (8, 6))

    def test_ctrl_c_interrupts_without_a_callback(self):
        room = make_room()
        timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
        with gnomon.Renderer(**LONG) as renderer:
            timer.start()
            with self.assertRaises(KeyboardInterrupt):
                renderer.render(room.scene)
        timer.join()

    def test_a_handler_runs_while_a_frame_is_rendered(self):
        room, ran = make_room(), []

        def handle(number, where):
            ran.append(number)
            # The main thread's own worker is busy, and this renders all the same.
            with gnomon.Renderer(size=(8, 6), threads=1) as inner:
                ran.append(inner.render(room.scene).size)
            renderer.cancel()

        before = signal.signal(signal.SIGUSR1, handle)
        try:
            with gnomon.Renderer(**LONG) as renderer:
                sent = []
                with self.assertRaises(gnomon.Interrupted):
                    renderer.render(room.scene, progress=lambda stage, done: sent or (
                        sent.append(1), os.kill(os.getpid(), signal.SIGUSR1)))
        finally:
            signal.signal(signal.SIGUSR1, before)
        self.assertEqual(ran, [signal.SIGUSR1, (8, 6)])


class Processes(unittest.TestCase):
    def in_child(self, method):
        context = multiprocessing.get_context(method)
        queue = context.Queue()
        process = context.Process(target=render_in_child, args=(queue,))
        process.start()
        answer = queue.get(timeout=60)
        process.join()
        return answer

    def test_a_forked_process_is_told_so_and_a_spawned_one_renders(self):
        gnomon.Renderer(size=(8, 6), threads=1).render(make_room().scene)
        self.assertIn("spawn", self.in_child("fork"))
        self.assertEqual(self.in_child("spawn"), (8, 6))

    def test_the_interpreter_ends_while_a_daemon_thread_renders(self):
        script = """
import threading, gnomon
from support import make_room
from threads_test import LONG
started = threading.Event()
def work():
    try:
        gnomon.Renderer(**LONG).render(make_room().scene, progress=lambda stage, done: started.set())
    except gnomon.Interrupted:
        pass
threading.Thread(target=work, daemon=True).start()
started.wait(30)
"""
        folders = [str(Path(gnomon.__file__).parents[1]), str(Path(__file__).resolve().parent)]
        result = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60,
                                env=os.environ | {"PYTHONPATH": ":".join(folders)})
        self.assertEqual((result.returncode, result.stderr), (0, ""))


if __name__ == "__main__":
    unittest.main()
