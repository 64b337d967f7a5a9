// SCENE_DIR/rig.json
//   {"schema": 1, "pipeline": "seeds", "board": "markers", "warnings": ["..."],
//    "sensors": [{"name": "rgb", "camera": CAMERA, "sensor_from_rig": POSE, "exposure_s",
//                 "shutter": "rolling" or "global", "readout_s", "linear_raw": false}]}
//   CAMERA: {"model": "opencv5", "width_px", "height_px", "fx_px", "fy_px", "cx_px", "cy_px",
//            "distortion": [5 numbers]}
//   POSE: {"rotation_wxyz": [4], "translation_m": [3]}
//
// SCENE_DIR/scene_camera.json: BOP's with one key more; BOP's keys are of the first sensor
//   {"0": {"cam_K": [9], "depth_scale": mm per unit of depth/, "cam_R_w2c": [9], "cam_t_w2c": [3,
//   mm],
//          "cousin": {"time_s", "rig_from_world": POSE,
//                     "sensors": [{"camera": CAMERA, "depth_unit_m", "images": ["color",
//                                  "grey", "raw", "depth"], "time_s": if not the frame's}]}}}
//   Poses are there only if the rig knows them. "cousin" keeps what BOP has no place for. Without
//   it (another program's files), the rig has one sensor, whose lens has the intrinsics of cam_K
//   and the distortion of rig.json.
//
// Images: NAME/000000.png (color, .jpg is read too; or grey), raw/ and depth/ of the first sensor,
// NAME_raw/ and NAME_depth/ of the others. A sensor named "depth" has its depth in depth/, in its
// own pixels, not in those of cam_K.

#include "sim/dataset/capture_io.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_json.h"
#include "sim/dataset/for_each_frame.h"
#include "sim/dataset/json_interop.h"
#include "sim/imaging/image_io.h"
#include "sim/types/memory_limit.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

fs::path image_file(const fs::path& scene_dir, const Capture& capture, std::size_t sensor,
                    ImageKind kind, int frame) {
  return scene_dir / image_folder(capture.rig, sensor, kind) / (six_digits(frame) + ".png");
}

std::string frame_context(const fs::path& file, int frame) {
  return file.string() + " (frame " + std::to_string(frame) + ")";
}

template <class Pixel>
void check_size(const Image<Pixel>& image, const Camera& camera, const fs::path& file, int frame) {
  if (image.width() == camera.width_px && image.height() == camera.height_px) return;
  throw std::runtime_error(frame_context(file, frame) + ": the image is " +
                           std::to_string(image.width()) + " x " + std::to_string(image.height()) +
                           " pixels; its camera has " + std::to_string(camera.width_px) + " x " +
                           std::to_string(camera.height_px));
}

/// Reads with `read`, adding the frame to its error.
template <class Read>
auto read_image(const fs::path& scene_dir, const fs::path& relative, const Camera& camera,
                int frame, const Read& read) {
  const fs::path file = resolve_inside(scene_dir, relative);
  if (!fs::exists(file))
    throw std::runtime_error(frame_context(scene_dir / relative, frame) + ": the image is missing");
  decltype(read(file)) image;
  try {
    image = read(file);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(std::string(error.what()) + " (frame " + std::to_string(frame) + ")");
  }
  check_size(image, camera, file, frame);
  return image;
}

void check_writable(const Capture& capture) {
  check_rig(capture.rig);
  std::set<int> ids;
  for (const Frame& frame : capture.frames) {
    const std::string name = "capture frame " + std::to_string(frame.id);
    if (frame.id < 0 || frame.id > 999999)
      throw std::invalid_argument(name + " is outside 0..999999");
    if (!ids.insert(frame.id).second) throw std::invalid_argument(name + " occurs twice");
    if (frame.sensors.size() != capture.rig.size()) {
      throw std::invalid_argument(name + " has " + std::to_string(frame.sensors.size()) +
                                  " sensors; the rig has " + std::to_string(capture.rig.size()));
    }
  }
}

void read_frame_images(const fs::path& scene_dir, const std::vector<SensorReport>& rig,
                       const std::vector<ImageKinds>& kinds, Frame& frame) {
  for (std::size_t s = 0; s < rig.size(); ++s) {
    SensorFrame& sensor = frame.sensors[s];
    const std::string name = six_digits(frame.id);
    const auto relative = [&](ImageKind kind) {
      return fs::path(image_folder(rig, s, kind)) / (name + ".png");
    };
    const Camera& camera = sensor.reported;
    if (kinds[s].color) {
      fs::path file = relative(ImageKind::color);
      if (!fs::exists(scene_dir / file) &&
          fs::exists(scene_dir / fs::path(file).replace_extension(".jpg"))) {
        file.replace_extension(".jpg");
      }
      sensor.color = read_image(scene_dir, file, camera, frame.id,
                                [](const fs::path& f) { return read_color(f); });
    }
    if (kinds[s].grey) {
      sensor.grey = read_image(scene_dir, relative(ImageKind::grey), camera, frame.id,
                               [](const fs::path& f) { return read_png8(f); });
    }
    if (kinds[s].raw) {
      sensor.raw = read_image(scene_dir, relative(ImageKind::raw), camera, frame.id,
                              [](const fs::path& f) { return read_png16(f); });
    }
    const bool is_foreign_depth =
        kinds[s].depth_if_there && fs::exists(scene_dir / relative(ImageKind::depth));
    if (is_foreign_depth && !kinds[s].depth_has_scale) {
      throw std::runtime_error(
          frame_context(scene_dir / "scene_camera.json", frame.id) +
          ": there is a depth image and no \"depth_scale\", millimetres a unit of it");
    }
    if (kinds[s].depth || is_foreign_depth) {
      sensor.depth = read_image(scene_dir, relative(ImageKind::depth), camera, frame.id,
                                [](const fs::path& f) { return read_png16(f); });
    }
  }
}

/// Of all images that the views list, in memory.
std::uint64_t image_bytes(const Capture& capture,
                          const std::vector<std::vector<ImageKinds>>& kinds) {
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < capture.frames.size(); ++i) {
    for (std::size_t s = 0; s < kinds[i].size(); ++s) {
      const Camera& camera = capture.frames[i].sensors[s].reported;
      const ImageKinds& kind = kinds[i][s];
      const std::size_t of_pixel = (kind.color ? sizeof(Rgb8) : 0) + (kind.grey ? 1 : 0) +
                                   (kind.raw ? sizeof(std::uint16_t) : 0) +
                                   (kind.depth || kind.depth_if_there ? sizeof(std::uint16_t) : 0);
      bytes = bytes_plus(bytes, of_pixel * static_cast<std::uint64_t>(camera.width_px) *
                                    static_cast<std::uint64_t>(camera.height_px));
    }
  }
  return bytes;
}

}  // namespace

void write_frame_images(const fs::path& scene_dir, const Capture& capture,
                        std::size_t frame_index) {
  const Frame& frame = capture.frames.at(frame_index);
  if (frame.sensors.size() != capture.rig.size()) {
    throw std::invalid_argument("capture frame " + std::to_string(frame.id) +
                                ": not one image set for each sensor");
  }
  for (std::size_t s = 0; s < frame.sensors.size(); ++s) {
    const SensorFrame& sensor = frame.sensors[s];
    const bool is_depth_alone = capture.rig[s].name == kDepthSensor;
    if (!sensor.color.empty() + !sensor.grey.empty() + is_depth_alone > 1) {
      throw std::invalid_argument("capture frame " + std::to_string(frame.id) + ": sensor \"" +
                                  capture.rig[s].name +
                                  "\" has two of colour, grey and depth alone, which would share "
                                  "a folder");
    }
    const auto write = [&](ImageKind kind, const auto& image) {
      if (image.empty()) return;
      const fs::path file = image_file(scene_dir, capture, s, kind, frame.id);
      check_size(image, sensor.reported, file, frame.id);
      fs::create_directories(file.parent_path());
      write_png(file, image);
    };
    write(ImageKind::color, sensor.color);
    write(ImageKind::grey, sensor.grey);
    write(ImageKind::raw, sensor.raw);
    write(ImageKind::depth, sensor.depth);
  }
}

std::vector<fs::path> frame_image_files(const Capture& capture, std::size_t frame_index) {
  const Frame& frame = capture.frames.at(frame_index);
  std::vector<fs::path> files;
  for (std::size_t s = 0; s < frame.sensors.size(); ++s) {
    const SensorFrame& sensor = frame.sensors[s];
    const auto add = [&](ImageKind kind, const auto& image) {
      if (!image.empty()) files.push_back(image_file({}, capture, s, kind, frame.id));
    };
    add(ImageKind::color, sensor.color);
    add(ImageKind::grey, sensor.grey);
    add(ImageKind::raw, sensor.raw);
    add(ImageKind::depth, sensor.depth);
  }
  return files;
}

void write_capture_index(const fs::path& scene_dir, const Capture& capture) {
  check_writable(capture);
  // Another shard may have written a frame's images, so what is on disk counts too; of grey ones
  // the frame itself must say that they are.
  std::vector<std::vector<ImageKinds>> kinds;
  for (const Frame& frame : capture.frames) {
    std::vector<ImageKinds>& of_frame = kinds.emplace_back();
    for (std::size_t s = 0; s < frame.sensors.size(); ++s) {
      const auto has = [&](ImageKind kind, const auto& image) {
        return !image.empty() || fs::exists(image_file(scene_dir, capture, s, kind, frame.id));
      };
      // Colour, grey and depth alone share a folder.
      const bool is_grey = !frame.sensors[s].grey.empty();
      const bool may_be_color = !is_grey && capture.rig[s].name != kDepthSensor;
      of_frame.push_back({.color = may_be_color && has(ImageKind::color, frame.sensors[s].color),
                          .grey = is_grey,
                          .raw = has(ImageKind::raw, frame.sensors[s].raw),
                          .depth = has(ImageKind::depth, frame.sensors[s].depth)});
    }
  }
  write_file(scene_dir / "rig.json", rig_to_json(capture));
  write_file(scene_dir / "scene_camera.json", scene_camera_to_json(capture, kinds));
}

void write_capture(const fs::path& scene_dir, const Capture& capture) {
  check_writable(capture);
  for_each_frame(capture.frames.size(),
                 [&](std::size_t i) { write_frame_images(scene_dir, capture, i); });
  write_capture_index(scene_dir, capture);
}

Capture read_capture(const fs::path& scene_dir) {
  const fs::path rig_file = scene_dir / "rig.json";
  const fs::path camera_file = scene_dir / "scene_camera.json";
  Capture capture = rig_from_json(read_file(rig_file), rig_file.string());
  const std::vector<std::vector<ImageKinds>> kinds =
      frames_from_json(read_file(camera_file), camera_file.string(), capture);
  check_memory(camera_file, image_bytes(capture, kinds),
               "images of " + std::to_string(capture.frames.size()) + " views");
  for_each_frame(capture.frames.size(), [&](std::size_t i) {
    read_frame_images(scene_dir, capture.rig, kinds[i], capture.frames[i]);
  });
  return capture;
}

std::vector<fs::path> scene_folders(const fs::path& dataset) {
  std::vector<fs::path> result;
  if (!fs::is_directory(dataset)) throw std::runtime_error(dataset.string() + ": not a folder");
  for (const fs::directory_entry& entry : fs::directory_iterator(dataset)) {
    if (entry.is_directory() && number_of_six_digits(entry.path().filename().string()) >= 0) {
      result.push_back(entry.path());
    }
  }
  std::sort(result.begin(), result.end());
  return result;
}

}  // namespace cousin
