#pragma once

#include <cstdint>
#include <cstring>

#include "sim/types/capture.h"
#include "sim/types/rng.h"

namespace cousin {

/// Same bits, so that NaN equals itself and -0 differs from 0.
template <class T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}
template <class T>
bool same_bits(const Image<T>& a, const Image<T>& b) {
  return a.width() == b.width() && a.height() == b.height() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
inline bool same_pose(const Pose& a, const Pose& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation_m == b.translation_m;
}

/// Digits that no short decimal has.
inline Pose odd_pose(Rng& rng) {
  const Eigen::Vector4d q =
      Eigen::Vector4d(normal(rng), normal(rng), normal(rng), normal(rng)).normalized();
  return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]),
          Eigen::Vector3d(normal(rng), normal(rng), 1 / 3.0)};
}

inline Camera odd_camera(int width, int height, double third) {
  Camera camera{.model = LensModel::opencv5, .width_px = width, .height_px = height};
  camera.fx_px = 50 + third / 3;
  camera.fy_px = 50.1 + third / 7;
  camera.cx_px = 0.49 * width;
  camera.cy_px = 0.52 * height;
  camera.distortion = {-0.05 / 3, 0.01 / 7, 1e-4 / 3, -1e-4 / 7, 1e-5 / 3};
  return camera;
}

template <class Pixel>
Image<Pixel> noise(int width, int height, Rng rng) {
  Image<Pixel> image(width, height);
  for (Pixel& pixel : image) {
    if constexpr (std::is_same_v<Pixel, Rgb8>) {
      pixel = {static_cast<std::uint8_t>(rng()), static_cast<std::uint8_t>(rng()),
               static_cast<std::uint8_t>(rng())};
    } else {
      pixel = static_cast<Pixel>(rng());
    }
  }
  return image;
}

/// Two sensors, three frames with a lens of their own each; the middle frame does not know its
/// pose.
inline Capture sample_capture() {
  Rng rng(7);
  Capture capture{.pipeline = "seeds", .board = "markers"};
  capture.warnings = {"a \"quoted\" warning"};
  capture.rig.push_back({.name = "rgb",
                         .camera = odd_camera(24, 18, 1),
                         .sensor_from_rig = odd_pose(rng),
                         .exposure_s = 0.01 / 3,
                         .shutter = Shutter::rolling,
                         .readout_s = 0.02 / 7,
                         .linear_raw = true});
  capture.rig.push_back(
      {.name = "ir_left", .camera = odd_camera(20, 10, 2), .sensor_from_rig = odd_pose(rng)});
  for (int i = 0; i < 3; ++i) {
    Frame frame{.id = 10 * i, .time_s = i / 3.0};
    if (i != 1) frame.rig_from_world = odd_pose(rng);
    frame.sensors.resize(2);
    frame.sensors[0].reported = odd_camera(24, 18, 1 + 0.1 * i);
    frame.sensors[0].color = noise<Rgb8>(24, 18, rng.fork(static_cast<std::uint64_t>(i)));
    frame.sensors[0].raw = noise<std::uint16_t>(24, 18, rng.fork("raw"));
    frame.sensors[1].reported = odd_camera(20, 10, 2);
    frame.sensors[1].color = noise<Rgb8>(20, 10, rng.fork("ir"));
    frame.sensors[1].depth = noise<std::uint16_t>(20, 10, rng.fork("depth"));
    frame.sensors[1].depth_unit_m = 0.0001 / 3;
    capture.frames.push_back(std::move(frame));
  }
  return capture;
}

/// A depth camera: colour, two infrared images and a sensor that hands over depth alone, each with
/// its own time.
inline Capture depth_camera_capture() {
  Rng rng(11);
  Capture capture{.pipeline = "seeds", .board = "none"};
  for (const char* name : {"rgb", "ir_left", "ir_right", "depth"}) {
    const bool is_color = capture.rig.empty();
    capture.rig.push_back({.name = name,
                           .camera = odd_camera(is_color ? 24 : 20, is_color ? 18 : 10, 1),
                           .sensor_from_rig = odd_pose(rng),
                           .raw_format = {}});
  }
  for (int i = 0; i < 2; ++i) {
    Frame frame{.id = i, .time_s = i / 3.0};
    frame.sensors.resize(4);
    for (std::size_t s = 0; s < 4; ++s) {
      frame.sensors[s].reported = capture.rig[s].camera;
      frame.sensors[s].time_s = frame.time_s + static_cast<double>(s) / 7000;
    }
    const Rng own = rng.fork(static_cast<std::uint64_t>(i));
    frame.sensors[0].color = noise<Rgb8>(24, 18, own);
    frame.sensors[1].grey = noise<std::uint8_t>(20, 10, own.fork("left"));
    frame.sensors[2].grey = noise<std::uint8_t>(20, 10, own.fork("right"));
    frame.sensors[3].depth = noise<std::uint16_t>(20, 10, own.fork("depth"));
    frame.sensors[3].depth_unit_m = 0.0001;
    capture.frames.push_back(std::move(frame));
  }
  return capture;
}

}  // namespace cousin
