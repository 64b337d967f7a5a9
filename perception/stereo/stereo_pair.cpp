#include "perception/stereo/stereo_pair.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include "sim/imaging/color.h"

namespace cousin {
namespace {

Pose right_from_left(const Capture& capture) {
  return capture.rig[1].sensor_from_rig * inverse(capture.rig[0].sensor_from_rig);
}

Image<float> brightness_of(const SensorFrame& sensor) {
  if (!sensor.color.empty()) return luma(sensor.color);
  Image<float> brightness(sensor.grey.width(), sensor.grey.height());
  for (std::size_t i = 0; i < brightness.size(); ++i)
    brightness.data()[i] = static_cast<float>(sensor.grey.data()[i]);
  return brightness;
}

Eigen::Vector2i size_of(const SensorFrame& sensor) {
  return sensor.color.empty() ? Eigen::Vector2i(sensor.grey.width(), sensor.grey.height())
                              : Eigen::Vector2i(sensor.color.width(), sensor.color.height());
}

std::string text_of(const Eigen::Vector2i& size) {
  return std::to_string(size.x()) + " x " + std::to_string(size.y());
}

/// Rectified so that the left image is in it whole, at its own scale in its middle: what a lens
/// compresses at its edge takes more room without distortion.
Rectification rectify_whole(const Camera& left, const Camera& right, const Pose& right_from_left) {
  constexpr double kMostGrowth = 1.5;  // fisheyes are cut
  const Rectification same = rectify(left, right, right_from_left, {1, 1, left.fx_px});
  const Lens lens(left);
  double half_x = 0.5 * (left.width_px - 1), half_y = 0.5 * (left.height_px - 1);
  const double most_x = kMostGrowth * half_x, most_y = kMostGrowth * half_y;
  const auto see = [&](double x, double y) {
    const auto ray = lens.unproject({x, y});
    if (!ray) return;
    const Eigen::Vector3d turned = same.rectified_from_left * *ray;
    if (!(turned.z() > 0)) return;
    half_x = std::max(half_x, left.fx_px * std::abs(turned.x() / turned.z()));
    half_y = std::max(half_y, left.fx_px * std::abs(turned.y() / turned.z()));
  };
  constexpr int kPlaces = 20;
  for (int i = 0; i <= kPlaces; ++i) {
    const double x = static_cast<double>(i) / kPlaces * (left.width_px - 1),
                 y = static_cast<double>(i) / kPlaces * (left.height_px - 1);
    for (const double end : {0.0, 1.0}) {
      see(x, end * (left.height_px - 1));
      see(end * (left.width_px - 1), y);
    }
  }
  const auto side = [](double half, double most) {
    return static_cast<int>(std::floor(2 * std::min(half, most) + 1 + 1e-6));
  };
  return rectify(left, right, right_from_left,
                 {side(half_x, most_x), side(half_y, most_y), left.fx_px});
}

}  // namespace

void check_stereo_rig(const Capture& capture) {
  if (capture.rig.size() < 2 || capture.rig[0].name == kDepthSensor ||
      capture.rig[1].name == kDepthSensor) {
    throw std::invalid_argument(
        "stereo reads a pair of cameras, the first two sensors, and the capture has " +
        (capture.rig.empty() ? std::string("none") : capture.rig[0].name) +
        (capture.rig.size() < 2 ? " alone" : " and " + capture.rig[1].name) +
        " (in simulation: --set rig=zed_hd720)");
  }
  const Eigen::Vector3d centre_m = inverse(right_from_left(capture)).translation_m;
  const double apart_m = centre_m.norm();
  if (!(apart_m >= 1e-6)) {
    throw std::invalid_argument("stereo: the rig reports both cameras, " + capture.rig[0].name +
                                " and " + capture.rig[1].name + ", at one place");
  }
  if (centre_m.x() / apart_m > std::sqrt(0.5)) return;
  throw std::invalid_argument(
      "stereo: the second camera, " + capture.rig[1].name + ", is not at the right of the first, " +
      capture.rig[0].name +
      (centre_m.x() / apart_m < -std::sqrt(0.5) ? ", but at its left: exchange the two" : ""));
}

Capture capture_of_pair(Image<std::uint8_t> left, Image<std::uint8_t> right, double focal_px,
                        double baseline_m) {
  Camera camera;
  camera.width_px = left.width();
  camera.height_px = left.height();
  camera.fx_px = camera.fy_px = focal_px;
  camera.cx_px = 0.5 * (camera.width_px - 1);
  camera.cy_px = 0.5 * (camera.height_px - 1);
  Capture capture;
  capture.rig.resize(2);
  capture.rig[0].name = "grey";
  capture.rig[1].name = "grey_right";
  capture.rig[1].sensor_from_rig.translation_m.x() = -baseline_m;
  Frame frame;
  frame.sensors.resize(2);
  for (std::size_t s = 0; s < 2; ++s) capture.rig[s].camera = frame.sensors[s].reported = camera;
  frame.sensors[0].grey = std::move(left);
  frame.sensors[1].grey = std::move(right);
  capture.frames.push_back(std::move(frame));
  return capture;
}

std::string why_no_stereo_pair(const Capture& capture, const Frame& frame, double most_apart_s) {
  if (frame.sensors.size() < 2) return "there is one image";
  const SensorFrame &left = frame.sensors[0], &right = frame.sensors[1];
  for (std::size_t s = 0; s < 2; ++s) {
    const Eigen::Vector2i size = size_of(frame.sensors[s]);
    const Camera& camera = frame.sensors[s].reported;
    if (size.x() == 0) return "there is no image of " + capture.rig[s].name;
    if (size.x() != camera.width_px || size.y() != camera.height_px) {
      return "the image of " + capture.rig[s].name + " has " + text_of(size) +
             " pixels and its calibration is of " + text_of({camera.width_px, camera.height_px});
    }
  }
  if (size_of(left) != size_of(right)) {
    return "the images have " + text_of(size_of(left)) + " and " + text_of(size_of(right)) +
           " pixels; a pair has one size";
  }
  const double apart_s =
      std::abs(right.time_s.value_or(frame.time_s) - left.time_s.value_or(frame.time_s));
  if (apart_s <= most_apart_s) return {};
  char text[100];
  std::snprintf(text, sizeof text, "the exposures are %.3f s apart; most_apart_s = %.3f", apart_s,
                most_apart_s);
  return text;
}

RectifiedPair rectified_pair(const Capture& capture, const Frame& frame) {
  check_stereo_rig(capture);
  const SensorFrame &left = frame.sensors.at(0), &right = frame.sensors.at(1);
  RectifiedPair pair;
  pair.geometry = rectify_whole(left.reported, right.reported, right_from_left(capture));
  pair.left_source = brightness_of(left);
  pair.right_source = brightness_of(right);
  pair.left = remap(pair.left_source, pair.geometry.left_px);
  pair.right = remap(pair.right_source, pair.geometry.right_px);
  return pair;
}

void use_right_map(RectifiedPair& pair, Image<Eigen::Vector2f> right_px) {
  pair.geometry.right_px = std::move(right_px);
  pair.right = remap(pair.right_source, pair.geometry.right_px);
}

}  // namespace cousin
