#include "perception/pipelines/small_photographs.h"

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

namespace cousin {
namespace {

/// How many pixels along a side become one.
int reduction(int width_px, int height_px, int largest_side_px) {
  const int longest = std::max(width_px, height_px);
  return largest_side_px <= 0 ? 1 : std::max(1, (longest + largest_side_px - 1) / largest_side_px);
}

Image<Rgb8> reduced(const Image<Rgb8>& image, int by) {
  Image<Rgb8> small(image.width() / by, image.height() / by);
  const int half = by * by / 2;
  for (int y = 0; y < small.height(); ++y) {
    for (int x = 0; x < small.width(); ++x) {
      std::array<int, 3> sum = {half, half, half};
      for (int j = 0; j < by; ++j) {
        for (int i = 0; i < by; ++i) {
          const Rgb8 c = image(by * x + i, by * y + j);
          sum[0] += c.r;
          sum[1] += c.g;
          sum[2] += c.b;
        }
      }
      const auto code = [&](std::size_t k) {
        return static_cast<std::uint8_t>(sum[k] / (by * by));
      };
      small(x, y) = {code(0), code(1), code(2)};
    }
  }
  return small;
}

}  // namespace

Camera reduced(const Camera& camera, int by) {
  if (by < 1) throw std::invalid_argument("reduced: by = " + std::to_string(by) + " is not >= 1");
  Camera small = camera;
  small.width_px /= by;
  small.height_px /= by;
  small.fx_px /= by;
  small.fy_px /= by;
  // A pixel's centre is the middle of the centres that it covers.
  small.cx_px = (camera.cx_px + 0.5) / by - 0.5;
  small.cy_px = (camera.cy_px + 0.5) / by - 0.5;
  return small;
}

Capture reduced(const Capture& capture, int largest_side_px) {
  Capture small;
  small.pipeline = capture.pipeline;
  small.board = capture.board;
  small.warnings = capture.warnings;
  if (!capture.rig.empty()) {
    small.rig.push_back(capture.rig.front());
    Camera& camera = small.rig.front().camera;
    camera = reduced(camera, reduction(camera.width_px, camera.height_px, largest_side_px));
  }
  for (const Frame& frame : capture.frames) {
    Frame next{.id = frame.id, .time_s = frame.time_s, .rig_from_world = frame.rig_from_world};
    if (!frame.sensors.empty()) {
      const SensorFrame& from = frame.sensors.front();
      const int by = reduction(from.reported.width_px, from.reported.height_px, largest_side_px);
      SensorFrame sensor{.reported = reduced(from.reported, by)};
      if (!from.color.empty()) sensor.color = by > 1 ? reduced(from.color, by) : from.color;
      next.sensors.push_back(std::move(sensor));
    }
    small.frames.push_back(std::move(next));
  }
  return small;
}

Poses reduced(Poses poses, const Capture& full, int largest_side_px) {
  std::map<int, const Camera*> sizes;  // of frames with a photograph
  for (const Frame& frame : full.frames) {
    if (!frame.sensors.empty()) sizes[frame.id] = &frame.sensors.front().reported;
  }
  for (FramePose& pose : poses) {
    const auto found = sizes.find(pose.frame);
    if (found == sizes.end()) continue;
    Camera& camera = pose.camera;
    const Camera& size = *found->second;
    if (camera.width_px != size.width_px || camera.height_px != size.height_px) continue;
    camera = reduced(camera, reduction(camera.width_px, camera.height_px, largest_side_px));
  }
  return poses;
}

Image<std::uint8_t> reduced_mask(const Image<std::uint8_t>& mask, int width_px, int height_px) {
  const int by = width_px > 0 ? mask.width() / width_px : 0;
  if (by < 1 || height_px < 1 || mask.width() / by != width_px || mask.height() / by != height_px)
    throw std::invalid_argument("a mask of " + std::to_string(mask.width()) + " x " +
                                std::to_string(mask.height()) + " pixels for a photograph of " +
                                std::to_string(width_px) + " x " + std::to_string(height_px));
  Image<std::uint8_t> small(width_px, height_px, 255);
  for (int y = 0; y < by * height_px; ++y) {
    for (int x = 0; x < by * width_px; ++x) {
      if (mask(x, y) == 0) small(x / by, y / by) = 0;
    }
  }
  return small;
}

}  // namespace cousin
