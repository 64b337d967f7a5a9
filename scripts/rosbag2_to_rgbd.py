#!/usr/bin/env python3
"""Turns a rosbag2 (sqlite3, or mcap without compression) into a folder for `cousin import OUT --format rgbd`.

    rosbag2_to_rgbd.py BAG OUT COLOR_TOPIC DEPTH_TOPIC [EXTRINSICS_TOPIC]

BAG is the bag's folder, or its .db3 or .mcap file. Topics are of sensor_msgs/Image or CompressedImage; each has a topic
camera_info beside it. EXTRINSICS_TOPIC is realsense2_camera's depth_to_color, for depth that is not in the colour
image's pixels. Writes rgb/ and depth/ by time stamps (16UC1 is millimetres, 32FC1 metres) and intrinsics.json.
"""
import json, mmap, pathlib, sqlite3, struct, sys, zlib

# encoding: bits, bytes a pixel, and which of these the file has, in its order: 16-bit PNG is big-endian, .npy little
PIXELS = {"rgb8": (8, 3, (0, 1, 2)), "bgr8": (8, 3, (2, 1, 0)), "rgba8": (8, 4, (0, 1, 2)), "bgra8": (8, 4, (2, 1, 0)),
          "mono8": (8, 1, (0,)), "16UC1": (16, 2, (1, 0)), "32FC1": (32, 4, (0, 1, 2, 3))}


class Cdr:
    """A message: numbers stand at multiples of their size, after 4 bytes that say their order."""
    def __init__(self, data):
        if data[:2] not in (b"\0\0", b"\0\1"): sys.exit("a message is not in plain CDR")
        self.order, self.data, self.at = "><"[data[1]], data[4:], 0

    def take(self, kind, count=1):
        self.at += -self.at % struct.calcsize(kind)
        values = struct.unpack_from(f"{self.order}{count}{kind}", self.data, self.at)
        self.at += struct.calcsize(kind) * count
        return values

    def block(self):
        (size,) = self.take("I")
        self.at += size
        if self.at > len(self.data): raise struct.error("a message is cut off")
        return self.data[self.at - size : self.at]

    def text(self): return self.block().rstrip(b"\0").decode()

    def header(self): return "%d.%09d" % (self.take("i") + self.take("I")), self.text()


def mcap_messages(data, at, schemas, topics):  # records: code, length, body [mcap.dev/spec]
    while at + 9 <= len(data):
        code, size = struct.unpack_from("<BQ", data, at)
        body, at = at + 9, at + 9 + size
        if at > len(data): raise struct.error("a record is cut off")
        if code == 3:
            name, length = struct.unpack_from("<HI", data, body)
            schemas[name] = data[body + 6 : body + 6 + length].decode()
        elif code == 4:
            channel, schema, length = struct.unpack_from("<HHI", data, body)
            topics[channel] = data[body + 8 : body + 8 + length].decode(), schemas.get(schema, "")
        elif code == 5:
            yield *topics[struct.unpack_from("<H", data, body)[0]], data[body + 22 : at]
        elif code == 6:
            (length,) = struct.unpack_from("<I", data, body + 28)
            if length: sys.exit("a compressed bag is not read; `ros2 bag convert` writes it without compression")
            yield from mcap_messages(data[body + 40 : at], 0, schemas, topics)


def messages(file):
    if file.suffix == ".mcap":
        with open(file, "rb") as opened, mmap.mmap(opened.fileno(), 0, access=mmap.ACCESS_READ) as data:
            yield from mcap_messages(data, 8, {}, {})
    else:
        yield from sqlite3.connect(f"{file.resolve().as_uri()}?mode=ro", uri=True).execute(
            "SELECT name, type, data FROM messages JOIN topics ON topics.id = topic_id ORDER BY timestamp, messages.id")


def png(width, height, bits, color, rows):
    chunk = lambda name, body: struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
    head = struct.pack(">IIBBBBB", width, height, bits, color, 0, 0, 0)
    data = zlib.compress(b"".join(b"\0" + row for row in rows), 1)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def npy(width, height, rows):
    head = b"{'descr': '<f4', 'fortran_order': False, 'shape': (%d, %d), }" % (height, width)
    return b"\x93NUMPY\1\0" + struct.pack("<H", 118) + head.ljust(117) + b"\n" + b"".join(rows)


def write_image(cdr, stem):
    (height, width), encoding = cdr.take("I", 2), cdr.text()
    (is_big,), (step,), data = cdr.take("B"), cdr.take("I"), cdr.block()
    if encoding not in PIXELS: sys.exit(f"the encoding {encoding} is not read, only {', '.join(PIXELS)}")
    bits, size, order = PIXELS[encoding]
    if not 0 < width * size <= step or not 0 < height * step <= len(data): raise struct.error("an image is cut off")
    order, rows = order[::-1] if bits > 8 and is_big else order, []
    for y in range(height):
        rows.append(bytearray(width * len(order)))
        for i, place in enumerate(order):
            rows[-1][i :: len(order)] = data[y * step + place : y * step + width * size : size]
    whole = npy(width, height, rows) if bits == 32 else png(width, height, bits, 2 if len(order) == 3 else 0, rows)
    stem.with_name(stem.name + (".npy" if bits == 32 else ".png")).write_bytes(whole)


def write_compressed(cdr, stem):
    form, data = cdr.text(), cdr.block()
    if "compressedDepth" in form: data = data[12:]  # behind what undoes the quantisation of 32FC1
    ending = ".jpg" if data[:2] == b"\xff\xd8" else ".png" if data[:4] == b"\x89PNG" else ""
    if form.startswith("32FC1") or not ending: sys.exit(f"the compressed format {form} is not read")
    stem.with_name(stem.name + ending).write_bytes(data)


def lens(cdr):
    frame, (height, width), model = cdr.header()[1], cdr.take("I", 2), cdr.text()
    coefficients = cdr.take("d", *cdr.take("I"))
    k, _, _, binning, roi = cdr.take("d", 9), cdr.take("d", 9), cdr.take("d", 12), cdr.take("I", 2), cdr.take("I", 2)
    return frame, {"width": width, "height": height, "fx": k[0], "fy": k[4], "cx": k[2], "cy": k[5], "model": model,
                   "coeffs": coefficients, "binning_x": binning[0], "binning_y": binning[1],
                   "roi": {"x_offset": roi[0], "y_offset": roi[1]}}


def main(bag, out, color, depth, extrinsics=""):
    files = [bag] if bag.is_file() else sorted(bag.glob("*.db3")) + sorted(bag.glob("*.mcap"))
    if not files: sys.exit(f"{bag}: no .db3 or .mcap")
    folders, result, seen = {color: out / "rgb", depth: out / "depth"}, {}, set()
    infos = {topic.removesuffix("/compressed").removesuffix("/compressedDepth").rsplit("/", 1)[0] + "/camera_info": name
             for topic, name in ((color, "color"), (depth, "depth"))}
    for folder in folders.values(): folder.mkdir(parents=True)
    for topic, kind, data in (message for file in files for message in messages(file)):
        seen.add(topic)
        if topic in folders:
            cdr = Cdr(data)
            stem = folders[topic] / cdr.header()[0]
            write_compressed(cdr, stem) if kind.endswith("CompressedImage") else write_image(cdr, stem)
        elif topic in infos:
            result[infos[topic]] = lens(Cdr(data))
        elif topic == extrinsics:
            r, t = (cdr := Cdr(data)).take("d", 9), cdr.take("d", 3)  # column by column
            result["depth_to_color"] = [[*r[i::3], t[i]] for i in range(3)] + [[0, 0, 0, 1]]
    if missing := ({color, depth, *infos} | {extrinsics} - {""}) - seen:
        sys.exit(f"{bag}: has no {', '.join(sorted(missing))}; it has {', '.join(sorted(seen))}")
    text = {name: value if name == "depth_to_color" else value[1] for name, value in result.items()}
    text["aligned"] = result["color"] == result["depth"]
    if any((out / "depth").glob("*.png")): text["depth_unit_m"] = 0.001
    (out / "intrinsics.json").write_text(json.dumps(text, indent=1))


if __name__ == "__main__":
    if not 5 <= len(sys.argv) <= 6: sys.exit(__doc__)
    try:
        main(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), *sys.argv[3:])
    except (struct.error, sqlite3.Error, ValueError, OSError, KeyError, RecursionError) as error:
        sys.exit(f"{sys.argv[1]}: not read: {error}")
