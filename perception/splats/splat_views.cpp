#include "perception/splats/splat_views.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim/imaging/undistort.h"

namespace cousin {
namespace {

constexpr int kLeastSide_px = 16;

/// What an output pixel covers of the input along one axis: shares of neighbours, summing to the
/// size of one output pixel.
struct Cover {
  int first = 0;
  std::vector<float> share;
};
std::vector<Cover> covers(int from, int to) {
  std::vector<Cover> result(static_cast<std::size_t>(to));
  for (int i = 0; i < to; ++i) {
    const double begin = static_cast<double>(from) * i / to;
    const double end = static_cast<double>(from) * (i + 1) / to;
    Cover& cover = result[static_cast<std::size_t>(i)];
    cover.first = static_cast<int>(begin);
    for (int k = cover.first; k < std::min(from, static_cast<int>(std::ceil(end))); ++k) {
      cover.share.push_back(
          static_cast<float>(std::min<double>(k + 1, end) - std::max<double>(k, begin)));
    }
  }
  return result;
}

/// Colours and weights averaged over areas. @param x, y  cover of each column and row of the result
SplatViewLevel averaged(const SplatViewLevel& level, const std::vector<Cover>& x,
                        const std::vector<Cover>& y) {
  const int width = static_cast<int>(x.size());
  const int height = static_cast<int>(y.size());
  SplatViewLevel result;
  for (Image<float>& channel : result.color.channel) channel = Image<float>(width, height);
  const bool weighted = !level.weight.empty();
  if (weighted) result.weight = Image<float>(width, height);
  const bool screened = !level.behind.empty();
  if (screened) result.behind = Image<float>(width, height);
  for (int row = 0; row < height; ++row) {
    const Cover& rows = y[static_cast<std::size_t>(row)];
    for (int column = 0; column < width; ++column) {
      const Cover& columns = x[static_cast<std::size_t>(column)];
      std::array<float, 3> sum{};
      float weights = 0, area = 0, behind = 0;
      for (std::size_t j = 0; j < rows.share.size(); ++j) {
        for (std::size_t i = 0; i < columns.share.size(); ++i) {
          const int from_x = columns.first + static_cast<int>(i);
          const int from_y = rows.first + static_cast<int>(j);
          const float share = rows.share[j] * columns.share[i];
          const float w = weighted ? share * level.weight(from_x, from_y) : share;
          for (std::size_t c = 0; c < 3; ++c) sum[c] += w * level.color.channel[c](from_x, from_y);
          if (screened) behind += w * level.behind(from_x, from_y);
          weights += w;
          area += share;
        }
      }
      for (std::size_t c = 0; c < 3; ++c)
        result.color.channel[c](column, row) = weights > 0 ? sum[c] / weights : 0;
      if (weighted) result.weight(column, row) = weights / area;
      if (screened) result.behind(column, row) = weights > 0 ? behind / weights : 0;
    }
  }
  return result;
}

SplatViewLevel planes_of(const Image<Rgb8>& image, const Camera& camera) {
  SplatViewLevel level;
  level.camera = camera;
  for (Image<float>& channel : level.color.channel)
    channel = Image<float>(image.width(), image.height());
  for (std::size_t i = 0; i < image.size(); ++i) {
    const Rgb8 code = image.data()[i];
    level.color.channel[0].data()[i] = static_cast<float>(code.r) / 255;
    level.color.channel[1].data()[i] = static_cast<float>(code.g) / 255;
    level.color.channel[2].data()[i] = static_cast<float>(code.b) / 255;
  }
  return level;
}

/// A screen's pixels as a pinhole camera sees them, interpolated as the photograph is.
Image<float> behind_of(const Image<std::uint8_t>& screen, const Camera& camera) {
  Image<float> behind(screen.width(), screen.height());
  for (std::size_t i = 0; i < screen.size(); ++i)
    behind.data()[i] = screen.data()[i] != 0 ? 1.0F : 0.0F;
  if (camera.model == LensModel::pinhole) return behind;
  behind =
      undistort(behind, camera, {.interpolation = UndistortConfig::Interpolation::cubic}).image;
  for (float& share : behind) {
    if (!std::isfinite(share)) share = 0;  // beyond the photograph, where nothing counts
  }
  return behind;
}

/// The photograph at full size as a pinhole camera's.
SplatViewLevel full_level(const Image<Rgb8>& image, const Camera& camera,
                          const Image<std::uint8_t>& mask, const Image<std::uint8_t>& screen) {
  const bool pinhole = camera.model == LensModel::pinhole;
  SplatViewLevel level;
  Image<std::uint8_t> counts = mask;
  if (pinhole) {
    level = planes_of(image, camera);
  } else {
    const Undistorted<Rgb8> straight =
        undistort(image, camera, {.interpolation = UndistortConfig::Interpolation::cubic});
    level = planes_of(straight.image, straight.camera);
    counts = straight.valid;
    if (!mask.empty()) {
      const Undistorted<std::uint8_t> shown =
          undistort(mask, camera, {.interpolation = UndistortConfig::Interpolation::nearest});
      for (std::size_t i = 0; i < counts.size(); ++i) {
        if (shown.image.data()[i] == 0) counts.data()[i] = 0;
      }
    }
  }
  if (!screen.empty()) level.behind = behind_of(screen, camera);
  if (std::all_of(counts.begin(), counts.end(), [](std::uint8_t c) { return c != 0; }))
    return level;
  level.weight = Image<float>(counts.width(), counts.height());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    level.weight.data()[i] = counts.data()[i] != 0 ? 1.0f : 0.0f;
    if (counts.data()[i] != 0) continue;
    for (Image<float>& channel : level.color.channel) channel.data()[i] = 0;
  }
  return level;
}

SplatViewLevel limited(SplatViewLevel level, int largest_side_px) {
  const int width = level.camera.width_px;
  const int height = level.camera.height_px;
  const int side = std::max(width, height);
  if (largest_side_px == 0 || side <= largest_side_px) return level;
  const auto shrunk = [&](int size) {
    return std::max(
        1, static_cast<int>(std::lround(static_cast<double>(size) * largest_side_px / side)));
  };
  SplatViewLevel result =
      averaged(level, covers(width, shrunk(width)), covers(height, shrunk(height)));
  result.camera = resized(level.camera, shrunk(width), shrunk(height));
  return result;
}

SplatViewLevel half_of(const SplatViewLevel& level) {
  const int width = level.camera.width_px / 2;
  const int height = level.camera.height_px / 2;
  SplatViewLevel result = averaged(level, covers(2 * width, width), covers(2 * height, height));
  result.camera = level.camera;
  result.camera.width_px = width;
  result.camera.height_px = height;
  result.camera.fx_px /= 2;
  result.camera.fy_px /= 2;
  result.camera.cx_px = (level.camera.cx_px + 0.5) / 2 - 0.5;
  result.camera.cy_px = (level.camera.cy_px + 0.5) / 2 - 0.5;
  return result;
}

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

/// @throws std::invalid_argument unless `pixels`, if there are any, have the image's size
void check_as_image(const std::string& name, const char* what, const Image<std::uint8_t>& pixels,
                    const Image<Rgb8>& image) {
  if (pixels.empty()) return;
  if (pixels.width() == image.width() && pixels.height() == image.height()) return;
  throw std::invalid_argument(name + ": the " + what + " is " +
                              size_text(pixels.width(), pixels.height()) + ", the image " +
                              size_text(image.width(), image.height()));
}

}  // namespace

void validate(const SplatViewsConfig& config) {
  const auto fail = [](const std::string& what) {
    throw std::invalid_argument("splat_views: " + what);
  };
  if (config.largest_side_px != 0 &&
      (config.largest_side_px < kLeastSide_px || config.largest_side_px > 65535))
    fail("largest_side_px = " + std::to_string(config.largest_side_px) + " is not 0 or 16..65535");
  if (!(config.most_pixels >= 1) || !std::isfinite(config.most_pixels))
    fail("most_pixels = " + std::to_string(config.most_pixels) + " is not a count of 1 or more");
}

Poses reported_poses(const Capture& capture) {
  Poses poses;
  for (const Frame& frame : capture.frames) {
    FramePose pose;
    pose.frame = frame.id;
    if (frame.rig_from_world && !frame.sensors.empty() && !capture.rig.empty()) {
      pose.status = PoseStatus::ok;
      pose.camera_from_world = capture.rig.front().sensor_from_rig * *frame.rig_from_world;
      pose.camera = frame.sensors.front().reported;
    }
    poses.push_back(pose);
  }
  return poses;
}

void check_size(const Camera& camera, const Image<float>& image, const std::string& name) {
  if (image.width() == camera.width_px && image.height() == camera.height_px) return;
  throw std::invalid_argument(
      name + " is " + std::to_string(image.width()) + " x " + std::to_string(image.height()) +
      ", its camera " + std::to_string(camera.width_px) + " x " + std::to_string(camera.height_px));
}

void check_sizes(const SplatViewLevel& level, const std::string& name) {
  for (const Image<float>& channel : level.color.channel)
    check_size(level.camera, channel, name + ": a channel");
  if (!level.weight.empty()) check_size(level.camera, level.weight, name + ": the weight");
  if (!level.behind.empty()) check_size(level.camera, level.behind, name + ": what is behind");
}

int halvings_of(const Camera& camera, int times) {
  const int side = std::min(camera.width_px, camera.height_px);
  int can = 0;
  while (can < times && (side >> (can + 1)) >= kLeastSide_px) ++can;
  return can;
}

SplatViewLevel halved(const SplatViewLevel& level, int times) {
  const int can = halvings_of(level.camera, times);
  if (can == 0) return level;
  SplatViewLevel result = half_of(level);
  for (int i = 1; i < can; ++i) result = half_of(result);
  return result;
}

std::vector<SplatView> splat_views(const Capture& capture, const Poses& poses,
                                   const std::vector<Image<std::uint8_t>>& masks,
                                   const SplatViewsConfig& config,
                                   const std::vector<Image<std::uint8_t>>& screens) {
  validate(config);
  const std::size_t frames = capture.frames.size();
  const auto fits = [&](const std::vector<Image<std::uint8_t>>& images) {
    return images.empty() || images.size() == frames;
  };
  if (poses.size() != frames || !fits(masks) || !fits(screens)) {
    throw std::invalid_argument("splat_views: " + std::to_string(poses.size()) + " poses, " +
                                std::to_string(masks.size()) + " masks and " +
                                std::to_string(screens.size()) + " screens for " +
                                std::to_string(frames) + " frames");
  }
  std::vector<SplatView> views;
  double pixels = 0;
  for (std::size_t i = 0; i < frames; ++i) {
    if (poses[i].status != PoseStatus::ok || capture.frames[i].sensors.empty()) continue;
    const Image<Rgb8>& image = capture.frames[i].sensors.front().color;
    if (image.empty()) continue;
    const Camera& camera = poses[i].camera;
    validate(camera);
    const std::string name = "splat_views: frame " + std::to_string(capture.frames[i].id);
    if (image.width() != camera.width_px || image.height() != camera.height_px) {
      throw std::invalid_argument(name + ": the image is " +
                                  size_text(image.width(), image.height()) + ", its camera " +
                                  size_text(camera.width_px, camera.height_px));
    }
    if (!masks.empty()) check_as_image(name, "mask", masks[i], image);
    if (!screens.empty()) check_as_image(name, "screen", screens[i], image);
    const double side = std::max(image.width(), image.height());
    const double scale =
        config.largest_side_px > 0 ? std::min(1.0, config.largest_side_px / side) : 1.0;
    pixels += scale * scale * static_cast<double>(image.size());
    views.push_back({static_cast<int>(i), poses[i].camera_from_world, {}});
  }
  if (pixels > config.most_pixels) {
    throw std::invalid_argument(
        "splat_views: " + std::to_string(views.size()) + " views have " + std::to_string(pixels) +
        " pixels; most_pixels is " + std::to_string(config.most_pixels) +
        "; fewer or smaller photographs, or less around what they are of, help");
  }
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t v) {
    SplatView& view = views[v];
    const auto i = static_cast<std::size_t>(view.frame);
    static const Image<std::uint8_t> kNone;
    view.full =
        limited(full_level(capture.frames[i].sensors.front().color, poses[i].camera,
                           masks.empty() ? kNone : masks[i], screens.empty() ? kNone : screens[i]),
                config.largest_side_px);
  });
  return views;
}

}  // namespace cousin
