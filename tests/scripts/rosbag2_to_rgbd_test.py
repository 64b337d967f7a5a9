#!/usr/bin/env python3
"""scripts/rosbag2_to_rgbd.py on small bags that are written here, byte by byte."""

import json
import pathlib
import sqlite3
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

SCRIPT = pathlib.Path(__file__).parents[2] / "scripts" / "rosbag2_to_rgbd.py"
COLOR, DEPTH, TURN = "/camera/color/image_raw", "/camera/depth/image_rect_raw", "/camera/extrinsics/depth_to_color"
LEFT_TURN = (0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0)  # column by column: x of depth is y of colour


class Cdr:
    """Writes little-endian CDR."""

    def __init__(self):
        self.data = b""

    def put(self, kind, *values):
        size = struct.calcsize(kind)
        self.data += b"\0" * (-len(self.data) % size) + struct.pack(f"<{len(values)}{kind}", *values)
        return self

    def block(self, data):
        self.put("I", len(data))
        self.data += data
        return self

    def text(self, text):
        return self.block(text.encode() + b"\0")

    def header(self, seconds, nanoseconds, frame):
        return self.put("i", seconds).put("I", nanoseconds).text(frame)

    def whole(self):
        return b"\0\1\0\0" + self.data


def image(time, encoding, width, height, data, step=None):
    message = Cdr().header(*time, "a frame").put("I", height, width).text(encoding).put("B", 0)
    return "sensor_msgs/msg/Image", message.put("I", step or len(data) // height).block(data).whole()


def compressed(time, form, data):
    return "sensor_msgs/msg/CompressedImage", Cdr().header(*time, "a").text(form).block(data).whole()


def camera_info(frame, width, height, focal, binning=0):
    message = Cdr().header(1, 2, frame).put("I", height, width).text("plumb_bob").put("I", 5).put("d", 0.1, 0, 0, 0, 0)
    message.put("d", focal, 0, 3, 0, focal, 2, 0, 0, 1).put("d", 1, 0, 0, 0, 1, 0, 0, 0, 1).put("d", *[0] * 12)
    return "sensor_msgs/msg/CameraInfo", message.put("I", binning, binning).put("I", 0, 0, 0, 0).put("B", 0).whole()


def extrinsics():
    return "realsense2_camera_msgs/msg/Extrinsics", Cdr().put("d", *LEFT_TURN).put("d", 0.015, 0, 0).whole()


RGB = bytes(range(18))  # 3 x 2
MILLIMETRES = struct.pack("<6H", 1000, 0, 2000, 3, 4, 65535)


def recording():
    """Topic and message in the order of time."""
    return [
        ("/camera/color/camera_info", camera_info("color", 3, 2, 500)),
        ("/camera/depth/camera_info", camera_info("depth", 3, 2, 400)),
        (TURN, extrinsics()),
        (COLOR, image((1700000000, 5), "rgb8", 3, 2, RGB)),
        (DEPTH, image((1700000000, 1000), "16UC1", 3, 2, MILLIMETRES)),
        ("/tf", ("tf2_msgs/msg/TFMessage", b"not looked at")),
    ]


def write_db3(file, messages):
    with sqlite3.connect(file) as bag:
        bag.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)")
        bag.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)")
        names = list(dict.fromkeys(topic for topic, _ in messages))
        for place, name in enumerate(names):
            kind = next(message[0] for topic, message in messages if topic == name)
            bag.execute("INSERT INTO topics VALUES(?, ?, ?, 'cdr')", (place, name, kind))
        for at, (topic, (_, data)) in enumerate(messages):
            bag.execute("INSERT INTO messages VALUES(?, ?, ?, ?)", (at, names.index(topic), at, data))
    bag.close()


def mcap_text(text):
    return struct.pack("<I", len(text)) + text.encode()


def record(code, body):
    return struct.pack("<BQ", code, len(body)) + body


def write_mcap(file, messages, compression=None):
    """Without chunks, or all records in one."""
    records = b""
    names = list(dict.fromkeys(topic for topic, _ in messages))
    for place, name in enumerate(names):
        kind = next(message[0] for topic, message in messages if topic == name)
        records += record(3, struct.pack("<H", place + 1) + mcap_text(kind) + mcap_text("ros2msg") + mcap_text(""))
        records += record(4, struct.pack("<HH", place, place + 1) + mcap_text(name) + mcap_text("cdr") + mcap_text(""))
    for at, (topic, (_, data)) in enumerate(messages):
        records += record(5, struct.pack("<HIQQ", names.index(topic), at, at, at) + data)
    if compression is not None:
        chunk = struct.pack("<QQQI", 0, 9, len(records), 0) + mcap_text(compression) + struct.pack("<Q", len(records))
        records = record(6, chunk + records)
    magic = b"\x89MCAP0\r\n"
    file.write_bytes(magic + record(1, mcap_text("ros2") + mcap_text("")) + records + record(2, b"\0" * 20) + magic)


def png_pixels(file):
    """Bytes of the rows of a PNG whose rows have no filter."""
    data = file.read_bytes()
    width, height, bits, color = struct.unpack_from(">IIBB", data, 16)
    at = data.index(b"IDAT")
    (size,) = struct.unpack_from(">I", data, at - 4)
    raw, row = zlib.decompress(data[at + 4 : at + 4 + size]), width * bits // 8 * (3 if color == 2 else 1)
    return (width, height, bits, color), b"".join(raw[y * (row + 1) + 1 : (y + 1) * (row + 1)] for y in range(height))


class Rosbag2ToRgbd(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)
        self.addCleanup(self.folder.cleanup)

    def run_script(self, messages, *topics, write=write_db3, name="bag.db3", **options):
        write(self.root / name, messages, **options)
        out = self.root / f"out{len(list(self.root.iterdir()))}"
        command = [sys.executable, SCRIPT, self.root / name, out, *(topics or (COLOR, DEPTH, TURN))]
        return subprocess.run(command, capture_output=True, text=True, check=False), out

    def expect_recording(self, result, out):
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(png_pixels(out / "rgb/1700000000.000000005.png"), ((3, 2, 8, 2), RGB))
        depth = png_pixels(out / "depth/1700000000.000001000.png")
        self.assertEqual(depth, ((3, 2, 16, 0), struct.pack(">6H", *struct.unpack("<6H", MILLIMETRES))))
        said = json.loads((out / "intrinsics.json").read_text())
        self.assertEqual([said["color"][key] for key in ("width", "height", "fx", "cx", "cy")], [3, 2, 500, 3, 2])
        self.assertEqual([said["depth"][key] for key in ("fx", "model")], [400, "plumb_bob"])
        self.assertEqual(said["color"]["coeffs"], [0.1, 0, 0, 0, 0])
        self.assertEqual(said["depth_to_color"], [[0, -1, 0, 0.015], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
        self.assertEqual((said["aligned"], said["depth_unit_m"]), (False, 0.001))

    def test_sqlite_and_mcap_give_the_same_folder(self):
        self.expect_recording(*self.run_script(recording()))
        self.expect_recording(*self.run_script(recording(), write=write_mcap, name="a.mcap"))
        self.expect_recording(*self.run_script(recording(), write=write_mcap, name="b.mcap", compression=""))

    def test_a_bags_folder_is_read_whole(self):
        (self.root / "bag").mkdir()
        write_db3(self.root / "bag/bag_0.db3", recording()[:4])
        write_db3(self.root / "bag/bag_1.db3", recording()[4:])
        command = [sys.executable, SCRIPT, self.root / "bag", self.root / "out", COLOR, DEPTH, TURN]
        result = subprocess.run(command, capture_output=True, text=True, check=False)
        self.expect_recording(result, self.root / "out")

    def test_orders_of_bytes_and_floats(self):
        bgr = bytes(RGB[i - i % 3 + 2 - i % 3] for i in range(18))
        padded = b"".join(bgr[y * 9 : y * 9 + 9] + b"pad" for y in range(2))
        floats = struct.pack("<6f", 1, 2, 3, 4, 5, 6)
        messages = recording()[:3] + [
            (COLOR, image((5, 0), "bgr8", 3, 2, padded, 12)),
            (DEPTH, image((5, 0), "32FC1", 3, 2, floats)),
        ]
        result, out = self.run_script(messages)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(png_pixels(out / "rgb/5.000000000.png")[1], RGB)
        npy = (out / "depth/5.000000000.npy").read_bytes()
        self.assertEqual((npy[:8], len(npy) - len(floats), npy[128:]), (b"\x93NUMPY\1\0", 128, floats))
        self.assertIn(b"'shape': (2, 3)", npy)
        self.assertNotIn("depth_unit_m", json.loads((out / "intrinsics.json").read_text()))

    def test_compressed_images_are_handed_on(self):
        jpeg, png = b"\xff\xd8\xff rest", b"\x89PNG rest"
        color, depth = COLOR + "/compressed", DEPTH + "/compressedDepth"
        messages = recording()[:3] + [
            (color, compressed((5, 0), "rgb8; jpeg compressed bgr8", jpeg)),
            (depth, compressed((5, 0), "16UC1; compressedDepth png", b"0123456789ab" + png)),
        ]
        result, out = self.run_script(messages, color, depth, TURN)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual((out / "rgb/5.000000000.jpg").read_bytes(), jpeg)
        self.assertEqual((out / "depth/5.000000000.png").read_bytes(), png)

    def test_depth_in_the_colour_images_pixels_is_said(self):
        messages = recording()
        messages[1] = ("/camera/depth/camera_info", camera_info("color", 3, 2, 500))
        result, out = self.run_script(messages, COLOR, DEPTH)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertTrue(json.loads((out / "intrinsics.json").read_text())["aligned"])

    def expect_refused(self, text, messages, *topics, **options):
        result, _ = self.run_script(messages, *topics, **options)
        self.assertNotEqual(result.returncode, 0)
        self.assertIn(text, result.stderr)
        self.assertNotIn("Traceback", result.stderr)

    def test_what_is_not_read_is_said(self):
        self.expect_refused("compressed bag", recording(), write=write_mcap, name="z.mcap", compression="zstd")
        self.expect_refused("has no /other; it has /camera", recording(), COLOR, DEPTH, "/other", name="1.db3")
        yuv = recording() + [(COLOR, image((9, 0), "yuv422_yuy2", 3, 2, b"0" * 12))]
        self.expect_refused("yuv422_yuy2 is not read", yuv, name="2.db3")
        cut = recording() + [(COLOR, image((9, 0), "rgb8", 300, 2, RGB))]
        self.expect_refused("an image is cut off", cut, name="3.db3")
        self.expect_refused("cut off", recording()[:3] + [(COLOR, ("sensor_msgs/msg/Image", b"\0\1\0\0" + b"\xff" * 20))], name="4.db3")
        rvl = recording() + [(DEPTH, compressed((9, 0), "16UC1; compressedDepth rvl", b"0" * 40))]
        rvl = [message for message in rvl if message[1][0] != "sensor_msgs/msg/Image" or message[0] == COLOR]
        self.expect_refused("rvl is not read", rvl, name="5.db3")

    def test_bytes_that_are_no_bag_are_an_error(self):
        for name in ("a.db3", "a.mcap"):
            file = self.root / name
            for data in (b"", b"\x89MCAP0\r\n" + b"\x04" + b"\xff" * 30, b"x" * 5000):
                file.write_bytes(data)
                command = [sys.executable, SCRIPT, file, self.root / f"{name}{len(data)}", COLOR, DEPTH]
                result = subprocess.run(command, capture_output=True, text=True, check=False)
                self.assertNotEqual(result.returncode, 0)
                self.assertNotIn("Traceback", result.stderr)


if __name__ == "__main__":
    unittest.main()
