# SPDX-License-Identifier: Apache-2.0
"""A client of `gnomon serve`, by Drake's glTF Render Client-Server API: images, what is kept, and what is refused.

    serve_test.py PROGRAM [MALFORMED REQUESTS]    numbers of malformed requests, and of those of the test of memory: 200
                                                  and 240 without them
    SEED=N                                        of the malformed requests: 1 without it
    SECONDS=N                                     send malformed requests for so long, however many they are
"""
import base64
import collections
import copy
import http.client
import itertools
import json
import math
import os
import random
import re
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
import unittest
import zlib

PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 else "gnomon"
MALFORMED = int(sys.argv.pop(1)) if len(sys.argv) > 1 and sys.argv[1].isdigit() else 200
REQUESTS = int(sys.argv.pop(1)) if len(sys.argv) > 1 and sys.argv[1].isdigit() else 240
SEED = int(os.environ.get("SEED", "1"))
SECONDS = float(os.environ.get("SECONDS", "0"))
MOST_GROWTH = 8 << 20   # bytes, of a server that has answered many requests


def memory_of(process):
    """The memory of a process that is resident, in bytes."""
    with open(f"/proc/{process}/statm") as statm:
        return int(statm.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def matrix(x=0.0, y=0.0, z=0.0, scale=1.0):
    return [scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, scale, 0, x, y, z, 1]


def make_scene(square=(0.0, 0.0, 0.0), camera=(0.0, 0.0, 2.0), wall=True):
    """A square of side 1 with label 300, and a wall behind it with label 7; the camera looks along -Z."""
    points = struct.pack("<12f", -0.5, -0.5, 0, 0.5, -0.5, 0, 0.5, 0.5, 0, -0.5, 0.5, 0)
    corners = struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    nodes = [{"mesh": 0, "matrix": matrix(*square)}, {"camera": 0, "matrix": matrix(*camera)}]
    if wall:
        nodes.append({"mesh": 1, "matrix": matrix(0, 0, -2, 20)})

    def label(value):
        return {"pbrMetallicRoughness": {"baseColorFactor": [(value & 255) / 255, (value >> 8) / 255, 0, 1],
                                         "metallicFactor": 0}}

    return {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.01, "zfar": 10}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": i}]} for i in range(2)],
        "materials": [label(300), label(7)],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-0.5, -0.5, 0],
                       "max": [0.5, 0.5, 0]}, {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
        "buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64," +
                     base64.b64encode(points + corners).decode()}],
    }


def fields_of(image_type, width=64, height=48, focal=60.0, center=None, **more):
    more = {name: value for name, value in (("width", width), ("height", height)) if not isinstance(value, int)} | more
    width, height = (value if isinstance(value, int) else 64 for value in (width, height))
    cx, cy = center or (width / 2, height / 2)
    fields = {"scene_sha256": "0" * 64, "image_type": image_type, "width": width, "height": height, "near": 0.01, "far": 50,
              "focal_x": focal, "focal_y": focal, "fov_x": 2 * math.atan(width / 2 / focal),
              "fov_y": 2 * math.atan(height / 2 / focal), "center_x": cx, "center_y": cy}
    if image_type == "depth":
        fields |= {"min_depth": 0.1, "max_depth": 10}
    return fields | more


def form(fields, scene):
    boundary = "----------------------a1b2c3"
    parts = [f'--{boundary}\r\nContent-Disposition: form-data; name="{name}"\r\n\r\n{value}\r\n'.encode()
             for name, value in fields.items() if value is not None]
    if scene is not None:
        parts.append(f'--{boundary}\r\nContent-Disposition: form-data; name="scene"; filename="scene.gltf"\r\n'
                     "Content-Type: model/gltf+json\r\n\r\n".encode() + scene + b"\r\n")
    return b"".join(parts) + f"--{boundary}--\r\n".encode(), f"multipart/form-data; boundary={boundary}"


def read_png(file):
    """Rows of (red, green, blue), of an 8-bit PNG without interlacing."""
    assert file[:8] == b"\x89PNG\r\n\x1a\n"
    data, at = b"", 8
    while at < len(file):
        length, kind = struct.unpack(">I4s", file[at:at + 8])
        if kind == b"IHDR":
            width, height, bits, color = struct.unpack(">IIBB", file[at + 8:at + 18])
        elif kind == b"IDAT":
            data += file[at + 8:at + 8 + length]
        at += 12 + length
    assert (bits, color) == (8, 2)
    raw, rows, above = zlib.decompress(data), [], bytes(3 * width)
    for y in range(height):
        kind, line = raw[y * (3 * width + 1)], bytearray(raw[y * (3 * width + 1) + 1:(y + 1) * (3 * width + 1)])
        for i in range(len(line)):
            a, b, c = (line[i - 3] if i >= 3 else 0), above[i], (above[i - 3] if i >= 3 else 0)
            nearest = min((abs(b - c), 0, a), (abs(a - c), 1, b), (abs(a + b - 2 * c), 2, c))[2]
            line[i] = (line[i] + (0, a, b, (a + b) // 2, nearest)[kind]) & 255
        rows.append([tuple(line[i:i + 3]) for i in range(0, len(line), 3)])
        above = bytes(line)
    return rows


def read_tiff(file):
    """Rows of floats, by the tags of the file."""
    assert file[:4] == b"II*\0"
    at, = struct.unpack("<I", file[4:8])
    count, = struct.unpack("<H", file[at:at + 2])
    tags = {}
    for i in range(count):
        tag, kind, number, value = struct.unpack("<HHII", file[at + 2 + 12 * i:at + 14 + 12 * i])
        tags[tag] = value & 0xFFFF if kind == 3 else value
        assert number == 1
    width, height = tags[256], tags[257]
    assert (tags[258], tags[259], tags[277], tags[339]) == (32, 1, 1, 3)
    values = struct.unpack(f"<{width * height}f", file[tags[273]:tags[273] + tags[279]])
    return [values[y * width:(y + 1) * width] for y in range(height)]


class Server:
    """`gnomon serve` at a free port."""

    def __init__(self, *options):
        self.process = subprocess.Popen([PROGRAM, "serve", "--address", "127.0.0.1:0", *options], stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True)
        line = self.process.stdout.readline()
        self.port = int(re.search(r":(\d+);", line)[1])
        # Read what it says, because a full pipe would stop it. The last of it is kept.
        self.said = collections.deque(maxlen=1000)
        self.reader = threading.Thread(target=lambda: self.said.extend(self.process.stdout), daemon=True)
        self.reader.start()

    def send(self, body, kind, path="/render", method="POST", headers=None):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=120)
        try:
            connection.request(method, path, body, {"Content-Type": kind, **(headers or {})})
            answer = connection.getresponse()
            return answer.status, answer.getheader("Content-Type"), answer.read()
        finally:
            connection.close()

    def render(self, fields, scene):
        return self.send(*form(fields, json.dumps(scene).encode() if isinstance(scene, dict) else scene))

    def kill(self):
        if self.process.poll() is None:
            self.process.kill()
        self.stop()

    def stop(self):
        if not self.process.stderr.closed:
            self.process.send_signal(signal.SIGINT)
            self.process.wait(timeout=30)
            self.reader.join(timeout=30)
            self.err = self.process.stderr.read()
            self.process.stdout.close(), self.process.stderr.close()
        return self.process.returncode, "".join(self.said), self.err


class Serve(unittest.TestCase):
    def setUp(self):
        self.server = Server("--samples", "1", "--max-upload", "1", "--max-size", "640x480")
        self.addCleanup(self.server.kill)

    def image(self, fields, scene):
        status, kind, body = self.server.render(fields, scene)
        self.assertEqual(status, 200, body)
        self.assertEqual(kind, "image/tiff" if fields["image_type"] == "depth" else "image/png")
        return read_tiff(body) if fields["image_type"] == "depth" else read_png(body)

    def test_depth_is_in_metres_with_what_is_out_of_range(self):
        rows = self.image(fields_of("depth"), make_scene())
        self.assertEqual((len(rows), len(rows[0])), (48, 64))
        self.assertAlmostEqual(rows[24][32], 2, places=5)
        self.assertAlmostEqual(rows[0][0], 4, places=5)
        near = self.image(fields_of("depth", min_depth=3, max_depth=3.5), make_scene())
        self.assertEqual((near[24][32], near[0][0]), (0, math.inf))
        nothing = self.image(fields_of("depth"), make_scene(wall=False))
        self.assertEqual(nothing[0][0], math.inf)

    def test_labels_are_the_colours_of_the_file_and_white_where_nothing_is(self):
        rows = self.image(fields_of("label"), make_scene())
        self.assertEqual({pixel for row in rows for pixel in row}, {(300 & 255, 300 >> 8, 0), (7, 0, 0)})
        self.assertEqual(rows[24][32], (44, 1, 0))
        rows = self.image(fields_of("label"), make_scene(wall=False))
        self.assertEqual(rows[0][0], (255, 255, 255))

    def test_intrinsics_place_the_image(self):
        # The square covers 30 x 30 pixels around the principal point, whose coordinates begin at the corner of the image.
        for cx, cy in ((32.0, 24.0), (20.0, 30.0), (40.5, 18.5)):
            rows = self.image(fields_of("label", center=(cx, cy)), make_scene())
            inside = [(x, y) for y, row in enumerate(rows) for x, pixel in enumerate(row) if pixel == (44, 1, 0)]
            for axis, middle, limit in ((0, cx, 64), (1, cy, 48)):
                values = [p[axis] + 0.5 for p in inside]
                self.assertAlmostEqual(min(values), max(0.5, middle - 14.5), delta=0.51)
                self.assertAlmostEqual(max(values), min(limit - 0.5, middle + 14.5), delta=0.51)

    def test_colours_are_lit_and_the_camera_of_the_file_is_used(self):
        rows = self.image(fields_of("color"), make_scene())
        self.assertGreater(max(rows[24][32]), 10)
        moved = self.image(fields_of("depth"), make_scene(camera=(0.0, 0.0, 5.0)))
        self.assertAlmostEqual(moved[24][32], 5, places=5)

    def test_an_answer_depends_on_its_request_alone(self):
        requests = [(kind, make_scene(square=(0.2 * i, 0.1 * i, 0.0), camera=(0.1 * i, 0.0, 2.0)))
                    for i in range(4) for kind in ("color", "depth", "label")]
        one_after_the_other = [self.server.render(fields_of(kind), scene)[2] for kind, scene in requests]
        self.assertEqual(len(set(one_after_the_other)), len(requests))
        for index in (11, 6, 7):
            fresh = Server("--samples", "1")
            kind, scene = requests[index]
            self.assertEqual(fresh.render(fields_of(kind), scene)[2], one_after_the_other[index], index)
            fresh.stop()
        code, out, err = self.server.stop()
        self.assertEqual((code, err), (0, ""))
        # The first request of each kind loads the scene; all others know it.
        self.assertEqual(out.count("of a known scene"), len(requests) - 3, out)

    def test_wrong_requests_are_refused_in_one_line(self):
        scene = make_scene()
        no_camera = copy.deepcopy(scene)
        del no_camera["nodes"][1]["camera"]
        outside = copy.deepcopy(scene)
        outside["buffers"][0]["uri"] = "../../../etc/passwd"
        cyclic = copy.deepcopy(scene)
        cyclic["nodes"][1]["children"] = [0]
        cyclic["nodes"][0]["children"] = [1]
        cases = [
            (fields_of("color", width=None), scene, 400, "width is missing"),
            (fields_of("colour"), scene, 400, "image_type"),
            (fields_of("color", width=641), scene, 400, "640"),
            (fields_of("color", width="1e2.5"), scene, 400, "width"),
            (fields_of("color", width=9.5), scene, 400, "whole"),
            (fields_of("color", focal_x="nan"), scene, 400, "focal_x"),
            (fields_of("color", far=0.001), scene, 400, "far"),
            (fields_of("depth", max_depth=None), scene, 400, "max_depth"),
            (fields_of("color"), None, 400, "scene is missing"),
            (fields_of("color"), b"no glTF", 400, "JSON"),
            (fields_of("color"), b"glTF\2\0\0\0" + b"\xff" * 12, 400, "cut off"),
            (fields_of("color"), b"[" * 100_000, 400, "deep"),
            (fields_of("color"), no_camera, 400, "camera"),
            (fields_of("color"), outside, 400, ""),
            (fields_of("color"), cyclic, 400, ""),
            (fields_of("color"), b" " * (2 << 20), 413, "large"),
        ]
        for fields, upload, status, words in cases:
            answer = self.server.render(fields, upload)
            self.assertEqual(answer[0], status, answer)
            self.assertEqual(answer[1], "text/plain")
            text = answer[2].decode()
            self.assertEqual(text.count("\n"), 1, text)
            self.assertIn(words, text)
        self.assertEqual(self.server.send(b"", "text/plain", "/", "GET")[0], 404)
        self.assertEqual(self.server.send(b"x", "text/plain", headers={"Content-Encoding": "gzip"})[0], 415)
        self.assertEqual(self.server.send(iter([b"x"]), "text/plain", headers={"Transfer-Encoding": "chunked"})[0], 411)
        self.assertEqual(self.server.render(fields_of("depth"), scene)[0], 200)
        code, out, err = self.server.stop()
        self.assertEqual((code, err), (0, ""))
        self.assertNotIn("passwd", "".join(line for line in out.splitlines() if "root:" in line))

    def test_malformed_requests_end_nothing(self):
        chance = random.Random(SEED)

        def damaged(data):
            data = bytearray(data)
            for _ in range(chance.randint(1, 12)):
                at = chance.randrange(max(len(data), 1))
                data[at:at + chance.choice((0, 1, 1, 40))] = bytes(chance.randrange(256) for _ in range(chance.choice((0, 1, 1, 9))))
            return bytes(data)

        answers = {}
        scene = json.dumps(make_scene()).encode()
        end = time.monotonic() + SECONDS
        sent = itertools.count() if SECONDS else range(MALFORMED)
        for i in itertools.takewhile(lambda _: not SECONDS or time.monotonic() < end, sent):
            body, kind = form(fields_of(("label", "depth", "label", "color")[i % 4], 16, 12), scene)
            start = f"POST /render HTTP/1.1\r\nHost: x\r\nContent-Type: {kind}\r\nConnection: close\r\n".encode()
            # Mostly a whole request with a damaged body, so that it is read to its end. Else anything may be damaged,
            # and the client says that no more will come; the HTTP library takes that for the end of the connection, and
            # may leave out the answer.
            whole = chance.random() < 0.8
            if whole:
                body = damaged(body)
                if chance.random() < 0.3:
                    start = start.replace(kind.encode(), damaged(kind.encode()).replace(b"\n", b" "))
            data = start + f"Content-Length: {len(body)}\r\n\r\n".encode() + body
            status, text = self.raw(data if whole else damaged(data), half_closed=not whole)
            answers[status] = answers.get(status, 0) + 1
            if whole:
                self.assertIsNotNone(status, data)
                if status >= 400:
                    self.assertEqual((text.count(b"\n"), text[-1:]), (1, b"\n"), text)
            self.assertIsNone(self.server.process.poll())
        self.assertGreater(answers.get(400, 0), sum(answers.values()) // 4, answers)
        self.assertEqual(self.server.render(fields_of("label"), make_scene())[0], 200)
        code, _, err = self.server.stop()
        self.assertEqual((code, err), (0, ""))
        if SECONDS:
            print(f"{sum(answers.values())} malformed requests in {SECONDS:g} s; answers by status: {answers}")

    def raw(self, data, half_closed):
        """The status and the text of what the server answers to bytes.

        0: it closes the connection before it has read them all, which may cut off its answer. None: there is no answer.
        """
        answer = b""
        with socket.create_connection(("127.0.0.1", self.server.port), timeout=60) as connection:
            connection.sendall(data)
            if half_closed:
                connection.shutdown(socket.SHUT_WR)
            try:
                while part := connection.recv(65536):
                    answer += part
            except ConnectionResetError:
                return 0, b""
        head, _, text = answer.partition(b"\r\n\r\n")
        status = re.match(rb"HTTP/1\.1 (\d{3}) ", head)
        return (int(status[1]) if status else None), text

    def test_many_requests_do_not_grow(self):
        # The renderers' memory fills in the first hundred requests, by up to 30 MB with many threads. Growth is what comes
        # after them.
        warm = 160
        used = []
        for i in range(warm + REQUESTS):
            # Every tenth shows another thing, which is loaded; every seventh is wrong.
            scene = make_scene(square=(0.01 * (i % 50), 0.0, 0.0), wall=i // 10 % 2 == 0)
            fields = fields_of(("depth", "label", "color")[i % 3], 32, 24)
            status = self.server.render(fields | ({"near": "x"} if i % 7 == 6 else {}), scene)[0]
            self.assertEqual(status, 400 if i % 7 == 6 else 200)
            if i in (warm - 1, warm + REQUESTS - 1):
                used.append(memory_of(self.server.process.pid))
        self.assertLess(used[1] - used[0], MOST_GROWTH, used)
        code, _, err = self.server.stop()
        self.assertEqual((code, err), (0, ""))

    def test_growth_is_noticed(self):
        # A process that keeps 60 KB of each of 200 requests.
        grows = "import sys; kept = [print(flush=True) or bytearray(b'x' * 60000) for _ in sys.stdin]"
        with subprocess.Popen([sys.executable, "-c", grows], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
            used = []
            for i in range(201):
                process.stdin.write("request\n")
                process.stdin.flush()
                process.stdout.readline()
                if i in (0, 200):
                    used.append(memory_of(process.pid))
            process.stdin.close()
        self.assertGreater(used[1] - used[0], MOST_GROWTH, used)

    def test_a_request_that_takes_too_long_is_ended(self):
        slow = Server("--request-time", "0.01", "--samples", "256")
        status, _, body = slow.render(fields_of("color", 640, 480), make_scene())
        self.assertEqual((status, body.count(b"\n")), (503, 1))
        self.assertEqual(slow.stop()[0], 0)

    def test_wrong_addresses_are_refused(self):
        for address, code in (("8000", 2), ("127.0.0.1:", 2), ("127.0.0.1:99999", 2), ("127.0.0.1:x", 2),
                              (f"127.0.0.1:{self.server.port}", 4), ("203.0.113.7:80", 4)):
            result = subprocess.run([PROGRAM, "serve", "--address", address], capture_output=True, text=True, timeout=60)
            self.assertEqual((result.returncode, result.stderr.count("\n")), (code, 1), (address, result))

    def test_it_listens_on_the_loopback_alone(self):
        if os.path.exists("/proc/net/tcp"):
            port = f"{self.server.port:04X}"
            with open("/proc/net/tcp") as table:
                local = [line.split()[1] for line in table if line.split()[1].endswith(":" + port) and line.split()[3] == "0A"]
            self.assertEqual(local, ["0100007F:" + port])


if __name__ == "__main__":
    unittest.main()
