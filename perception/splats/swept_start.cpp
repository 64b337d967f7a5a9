#include "perception/splats/swept_start.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "perception/cloud/fuse.h"
#include "perception/segment/green.h"

namespace cousin {
namespace {

constexpr double kDarkLuma = 0.4;                         // of what is bright in the photographs
constexpr double kLeastFuse_m = 1e-6, kMostFuse_m = 0.1;  // what FuseConfig takes

std::vector<SplatView> small_views(std::span<const SplatView> views, int largest_side_px) {
  std::vector<SplatView> result;
  for (const SplatView& view : views) {
    int times = 0;
    for (int side = std::max(view.full.camera.width_px, view.full.camera.height_px);
         side > largest_side_px; side /= 2)
      ++times;
    result.push_back({view.frame, view.camera_from_world, halved(view.full, times)});
  }
  return result;
}

Image<Rgb8> codes_of(const ColorPlanes& planes) {
  const auto code = [](float value) {
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0F, 1.0F)));
  };
  Image<Rgb8> image(planes.channel[0].width(), planes.channel[0].height());
  for (std::size_t i = 0; i < image.size(); ++i)
    image.data()[i] = {code(planes.channel[0].data()[i]), code(planes.channel[1].data()[i]),
                       code(planes.channel[2].data()[i])};
  return image;
}

/// The 95 % quantile of each channel over all views where they have weight.
std::array<double, 3> bright_of(std::span<const SplatView> views) {
  std::array<double, 3> bright{};
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<float> values;
    for (const SplatView& view : views) {
      const Image<float>&channel = view.full.color.channel[c], &weight = view.full.weight;
      for (std::size_t i = 0; i < channel.size(); ++i) {
        if (weight.empty() || weight.data()[i] > 0.5F) values.push_back(channel.data()[i]);
      }
    }
    if (values.empty()) continue;
    const auto high = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 95 / 100);
    std::nth_element(values.begin(), high, values.end());
    bright[c] = static_cast<double>(*high);
  }
  return bright;
}

/// Under lamps of some wavelengths alone luma, by which surfaces are matched, may be dark and flat:
/// then greys in its place, each channel weighed by how bright it is, their brightest at 0.8.
void lighten(std::vector<SplatView>& views) {
  const std::array<double, 3> bright = bright_of(views);
  if (0.299 * bright[0] + 0.587 * bright[1] + 0.114 * bright[2] >= kDarkLuma) return;
  double squares = 0;
  for (const double b : bright) squares += b * b;
  if (!(squares > 0)) return;
  for (SplatView& view : views) {
    std::array<Image<float>, 3>& channel = view.full.color.channel;
    for (std::size_t i = 0; i < channel[0].size(); ++i) {
      double grey = 0;
      for (std::size_t c = 0; c < 3; ++c)
        grey += 0.8 / squares * bright[c] * static_cast<double>(channel[c].data()[i]);
      for (Image<float>& one : channel) one.data()[i] = static_cast<float>(grey);
    }
  }
}

/// The views as a capture of pinhole cameras.
Capture capture_of(std::span<const SplatView> views) {
  Capture capture;
  capture.rig.resize(1);
  for (const SplatView& view : views) {
    Frame frame;
    frame.id = static_cast<int>(capture.frames.size());
    frame.sensors.resize(1);
    frame.sensors[0].reported = view.full.camera;
    frame.sensors[0].color = codes_of(view.full.color);
    capture.frames.push_back(std::move(frame));
  }
  return capture;
}

Poses poses_of(std::span<const SplatView> views) {
  Poses poses;
  for (const SplatView& view : views) {
    FramePose pose;
    pose.frame = static_cast<int>(poses.size());
    pose.status = PoseStatus::ok;
    pose.camera_from_world = view.camera_from_world;
    pose.camera = view.full.camera;
    poses.push_back(pose);
  }
  return poses;
}

/// What a pixel spans at the median of all depths; zero if there are none.
double pixel_m(std::span<const SplatView> views, const Depths& depths) {
  std::vector<double> spans_m;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Image<float>& depth_m = depths[v].depth_m;
    for (std::size_t i = 0; i < depth_m.size(); ++i) {
      if (std::isfinite(depth_m.data()[i]))
        spans_m.push_back(static_cast<double>(depth_m.data()[i]) / views[v].full.camera.fx_px);
    }
  }
  if (spans_m.empty()) return 0;
  const auto middle = spans_m.begin() + static_cast<std::ptrdiff_t>(spans_m.size() / 2);
  std::nth_element(spans_m.begin(), middle, spans_m.end());
  return *middle;
}

void check(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw std::invalid_argument("swept start: " + std::string(name) + " = " + std::to_string(value) +
                              " is not in " + std::to_string(low) + " .. " + std::to_string(high));
}

}  // namespace

void validate(const SweptStartConfig& config) {
  check("largest_side_px", config.largest_side_px, 32, 100000);
  check("voxel_px", config.voxel_px, 0.01, 100);
  check("agreement_px", config.agreement_px, 0.01, 100);
  check("most_points", config.most_points, 0, static_cast<double>(kMostStartPoints));
  check("opacity", config.opacity, 1e-6, 1 - 1e-6);
  validate(config.mvs);
  validate(config.exposures);
}

SweptStart swept_start(std::span<const SplatView> views, const SweepVolume& volume,
                       const SweptStartConfig& config) {
  validate(config);
  std::vector<SplatView> small = small_views(views, config.largest_side_px);
  const Poses poses = poses_of(small);
  std::vector<SplatView> matched = small;
  lighten(matched);
  const Depths depths = estimate_depths(capture_of(matched), poses, volume, config.mvs);
  std::vector<Image<float>> depths_m;
  for (const FrameDepth& depth : depths) depths_m.push_back(depth.depth_m);

  SweptStart start;
  start.exposures = estimate_exposures(small, depths_m, config.exposures);
  for (std::size_t v = 0; v < small.size(); ++v)
    small[v].full = at_mean_exposure(std::move(small[v].full), start.exposures.gain_of(v),
                                     start.exposures.vignetting);
  const double span_m = pixel_m(small, depths);
  if (span_m == 0) return start;
  FuseConfig fuse;
  fuse.voxel_m = std::clamp(config.voxel_px * span_m, kLeastFuse_m, kMostFuse_m);
  fuse.agreement_m = std::clamp(config.agreement_px * span_m, kLeastFuse_m, kMostFuse_m);
  GreenConfig no_screen;
  no_screen.hue_low = 1;
  no_screen.hue_high = 0;
  const Cloud cloud = fuse_depths(capture_of(small), poses, depths, no_screen, fuse);
  const std::size_t count = std::min(cloud.size(), static_cast<std::size_t>(config.most_points));
  for (std::size_t i = 0; i < count; ++i) {
    const CloudPoint& point = cloud[i * cloud.size() / count];
    start.points.push_back({point.position_m.cast<double>(), point.color,
                            point.normal.cast<double>(), config.opacity});
  }
  return start;
}

}  // namespace cousin
