#include "perception/mvs/plane_sweep.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "perception/mvs/reference_depth.h"
#include "sim/config/limits.h"
#include "sim/types/no_value.h"

namespace cousin {
namespace {

/// Which frames can be used: posed, with a colour image of the lens's size.
std::vector<int> usable_frames(const Capture& capture, const Poses& poses) {
  std::vector<int> usable;
  for (std::size_t i = 0; i < capture.frames.size(); ++i) {
    if (poses[i].status != PoseStatus::ok || capture.frames[i].sensors.empty()) continue;
    const Image<Rgb8>& image = capture.frames[i].sensors[0].color;
    if (image.empty()) continue;
    const Camera& camera = poses[i].camera;
    if (image.width() != camera.width_px || image.height() != camera.height_px) {
      throw std::invalid_argument("frame " + std::to_string(capture.frames[i].id) +
                                  ": the image is " + std::to_string(image.width()) + " x " +
                                  std::to_string(image.height()) + " px, its camera " +
                                  std::to_string(camera.width_px) + " x " +
                                  std::to_string(camera.height_px));
    }
    usable.push_back(static_cast<int>(i));
  }
  return usable;
}

std::vector<int> evenly_spread(int count, int wanted) {
  std::vector<int> chosen;
  if (wanted <= 0 || wanted >= count) wanted = count;
  for (int i = 0; i < wanted; ++i) {
    chosen.push_back(static_cast<int>(static_cast<long long>(i) * count / wanted));
  }
  return chosen;
}

/// Of the plane 1/Z = inverse_depth + slope_x (x - x_p) + slope_y (y - y_p), which is n . X = 1:
/// the camera is on the side that n points away from.
Eigen::Vector3f normal_of(const ReferenceDepth& depth, const MvsView& view, int x, int y) {
  const float slope_x = depth.slope_x(x, y), slope_y = depth.slope_y(x, y);
  const Eigen::Vector3f n(
      slope_x, slope_y,
      depth.inverse_depth(x, y) - slope_x * view.ray_x(x, y) - slope_y * view.ray_y(x, y));
  const float length = n.norm();
  if (!(length > 0) || !std::isfinite(length)) return Eigen::Vector3f::Zero();
  return n / -length;
}

/// Depth on the whole original image from the rectangle that was reconstructed.
/// @param kept_m  of `found` what is consistent; NaN = none
FrameDepth whole_image(const Image<Rgb8>& photograph, const MvsView& view,
                       const ReferenceDepth& found, const Image<float>& kept_m,
                       const MvsConfig& config) {
  const int width = photograph.width(), height = photograph.height();
  FrameDepth result{0, Image<float>(width, height, kNone), Image<float>(width, height, kNone)};
  if (config.normals)
    result.normal = Image<Eigen::Vector3f>(width, height, Eigen::Vector3f::Zero());
  for (int y = 0; y < view.rect.height; ++y) {
    for (int x = 0; x < view.rect.width; ++x) {
      if (!std::isfinite(kept_m(x, y))) continue;
      const int at_x = view.rect.x0 + x, at_y = view.rect.y0 + y;
      result.depth_m(at_x, at_y) = kept_m(x, y);
      result.sigma_m(at_x, at_y) = found.sigma_m(x, y);
      if (config.normals) result.normal(at_x, at_y) = normal_of(found, view, x, y);
    }
  }
  return result;
}

}  // namespace

Fields fields(MvsConfig& c) {
  return {
      {"neighbours", &c.neighbours, "views each reference is matched with", 2, 32},
      {"window_px", &c.window_px, "side of the matching window, odd", 3, 21},
      {"step_px", &c.step_px, "depth step as disparity", 0.1, 4},
      {"min_angle_rad", &c.min_angle_rad, "least parallax to a neighbour", 0.005, 1.5},
      {"max_angle_rad", &c.max_angle_rad, "most parallax to a neighbour", 0.01, 1.57},
      {"min_score", &c.min_score, "least mean correlation", 0, 1},
      {"consistent_views", &c.consistent_views, "other views whose depth agrees", 0, 10},
      {"consistency_px", &c.consistency_px, "agreement in the image", 0.05, 10},
      {"consistency_depth", &c.consistency_depth, "agreement in depth, relative", 1e-5, 0.1},
      {"normals", &c.normals, "also normals of the surfaces, 12 bytes a pixel of each reference"},
      {"max_references", &c.max_references, "views with depth, evenly spread; 0 = all", 0, 100000}};
}

void validate(const MvsConfig& config) {
  MvsConfig copy = config;
  check_limits(fields(copy), "mvs");
  if (config.window_px % 2 == 0) {
    throw std::invalid_argument("mvs.window_px = " + std::to_string(config.window_px) +
                                " is not odd");
  }
  if (config.min_angle_rad >= config.max_angle_rad) {
    throw std::invalid_argument(
        "mvs.min_angle_rad = " + std::to_string(config.min_angle_rad) +
        " is not below mvs.max_angle_rad = " + std::to_string(config.max_angle_rad));
  }
}

Depths estimate_depths(const Capture& capture, const Poses& poses, const SweepVolume& volume,
                       const MvsConfig& config) {
  validate(config);
  if (poses.size() != capture.frames.size()) {
    throw std::invalid_argument("multi-view stereo: " + std::to_string(poses.size()) +
                                " poses for " + std::to_string(capture.frames.size()) + " frames");
  }
  if (!((volume.high_m - volume.low_m).minCoeff() > 0) || !volume.low_m.allFinite() ||
      !volume.high_m.allFinite()) {
    throw std::invalid_argument("multi-view stereo: the swept volume is empty or not finite");
  }
  Depths result(capture.frames.size());
  for (std::size_t i = 0; i < result.size(); ++i) result[i].frame = capture.frames[i].id;

  // Undistort once.
  const std::vector<int> usable = usable_frames(capture, poses);
  std::vector<std::optional<MvsView>> prepared(usable.size());
  tbb::parallel_for(std::size_t{0}, usable.size(), [&](std::size_t i) {
    prepared[i] = prepare_view(capture, poses, usable[i], volume);
  });
  std::vector<MvsView> views;
  for (std::optional<MvsView>& view : prepared) {
    if (view) views.push_back(std::move(*view));
  }

  // Which views get a depth, and from which others.
  std::vector<int> references;
  std::vector<std::vector<int>> neighbours;
  for (const int i : evenly_spread(static_cast<int>(views.size()), config.max_references)) {
    std::vector<int> chosen = choose_neighbours(views, i, volume, config);
    if (chosen.size() < 2) continue;
    references.push_back(i);
    neighbours.push_back(std::move(chosen));
  }

  std::vector<ReferenceDepth> depths(references.size());
  tbb::parallel_for(std::size_t{0}, references.size(), [&](std::size_t i) {
    depths[i] = sweep_reference(views, references[i], neighbours[i], volume, config);
    refine_slanted(views, references[i], neighbours[i], volume, config, depths[i]);
  });

  const std::vector<Image<float>> kept_m = consistent_depths_m(views, references, depths, config);
  tbb::parallel_for(std::size_t{0}, references.size(), [&](std::size_t i) {
    const MvsView& view = views[static_cast<std::size_t>(references[i])];
    const auto frame = static_cast<std::size_t>(view.index);
    const Image<Rgb8>& image = capture.frames[frame].sensors[0].color;
    result[frame] = whole_image(image, view, depths[i], kept_m[i], config);
    result[frame].frame = capture.frames[frame].id;
  });
  return result;
}

}  // namespace cousin
