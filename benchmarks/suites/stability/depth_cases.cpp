#include "benchmarks/suites/stability/depth_cases.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>

#include "perception/cloud/fuse.h"
#include "perception/mvs/plane_sweep.h"
#include "sim/types/pose.h"

namespace cousin {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr int kViews = 6;
constexpr int kWidth = 160, kHeight = 120;
const Eigen::Vector3d kNormal = Eigen::Vector3d(0.2, -0.1, 1).normalized();

/// A square of 8 cm in the plane through zero with kNormal, seen from 0.3 m.
struct SlantedSquare {
  Capture capture;
  Poses poses;
  Depths depths;  ///< true, with a standard deviation of 0.1 mm
};

/// Brightness of 0.1 to 0.9, of periods from 1.9 to 6 mm: no two places of a window's size alike.
double texture(const Eigen::Vector3d& p) {
  const double wave = std::sin(p.dot(Eigen::Vector3d(1900, 1100, 0))) +
                      std::sin(p.dot(Eigen::Vector3d(-900, 2600, 0)) + 1) +
                      std::sin(p.dot(Eigen::Vector3d(3300, 400, 0)) + 2) +
                      std::sin(p.dot(Eigen::Vector3d(700, -1300, 0)) + 3);
  return 0.5 + 0.1 * wave;
}

Camera square_camera() {
  Camera camera;
  camera.width_px = kWidth;
  camera.height_px = kHeight;
  camera.fx_px = camera.fy_px = 500;
  camera.cx_px = 0.5 * (kWidth - 1);
  camera.cy_px = 0.5 * (kHeight - 1);
  return camera;
}

/// @param contrast  of the texture; @param scale  of the scene; @param offset_m  of the world
SlantedSquare slanted_square(double contrast = 1, double scale = 1,
                             const Eigen::Vector3d& offset_m = Eigen::Vector3d::Zero()) {
  SlantedSquare square;
  const Camera camera = square_camera();
  square.capture.rig.push_back({.camera = camera});
  for (int i = 0; i < kViews; ++i) {
    const double turn = 2 * M_PI * i / kViews;
    Pose pose = look_at({0.08 * std::cos(turn), 0.08 * std::sin(turn), 0.3}, {0, 0, 0});
    const Eigen::Vector3d eye = centre_in_world_m(pose);
    const Eigen::Matrix3d world_from_camera = pose.rotation.toRotationMatrix().transpose();
    Image<Rgb8> color(kWidth, kHeight);
    Image<float> depth_m(kWidth, kHeight, kNan);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const Eigen::Vector3d ray =
            world_from_camera * Eigen::Vector3d((x - camera.cx_px) / camera.fx_px,
                                                (y - camera.cy_px) / camera.fy_px, 1);
        const double z = -kNormal.dot(eye) / kNormal.dot(ray);
        const Eigen::Vector3d p = eye + z * ray;
        if (p.head<2>().cwiseAbs().maxCoeff() > 0.04) continue;
        depth_m(x, y) = static_cast<float>(scale * z);
        const auto code =
            static_cast<std::uint8_t>(std::lround(255 * (0.5 + contrast * (texture(p) - 0.5))));
        color(x, y) = {code, code, code};
      }
    }
    pose.translation_m *= scale;
    pose.translation_m -= pose.rotation * offset_m;
    Frame frame;
    frame.id = i;
    frame.sensors.push_back({.reported = camera, .color = std::move(color)});
    square.capture.frames.push_back(std::move(frame));
    FramePose known;
    known.frame = i;
    known.status = PoseStatus::ok;
    known.camera_from_world = pose;
    known.camera = camera;
    square.poses.push_back(known);
    square.depths.push_back(
        {i, std::move(depth_m), Image<float>(kWidth, kHeight, static_cast<float>(1e-4 * scale))});
  }
  return square;
}

SweepVolume volume_about(const Eigen::Vector3d& offset_m) {
  const Eigen::Vector3d half(0.05, 0.05, 0.03);
  return {offset_m - half, offset_m + half};
}

/// What a sweep says beside the truth.
struct Swept {
  int depths = 0;
  double share = 0;     ///< of the pixels with a true depth
  double median_m = 0;  ///< of the absolute errors; NaN without depths
  double wrong = 0;     ///< share of the depths that are more than 2 mm off or on nothing
};
Swept sweep(const SlantedSquare& square, const SweepVolume& volume) {
  MvsConfig config;
  config.window_px = 5;
  const Depths depths = estimate_depths(square.capture, square.poses, volume, config);
  Swept swept;
  std::vector<double> errors;
  int known = 0;
  for (std::size_t v = 0; v < depths.size(); ++v) {
    const Image<float>& truth = square.depths[v].depth_m;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      known += std::isfinite(truth.data()[i]) ? 1 : 0;
      if (depths[v].depth_m.empty() || !std::isfinite(depths[v].depth_m.data()[i])) continue;
      const auto error =
          static_cast<double>(std::abs(depths[v].depth_m.data()[i] - truth.data()[i]));
      swept.wrong += error <= 0.002 ? 0 : 1;
      if (std::isfinite(error)) errors.push_back(error);
      ++swept.depths;
    }
  }
  swept.share = static_cast<double>(errors.size()) / std::max(known, 1);
  if (swept.depths > 0) swept.wrong /= swept.depths;
  std::sort(errors.begin(), errors.end());
  swept.median_m =
      errors.empty() ? std::numeric_limits<double>::quiet_NaN() : errors[errors.size() / 2];
  return swept;
}

void add_solved(const std::string& name, const Swept& swept, std::vector<StabilityRow>& rows) {
  rows.push_back(make_row(name, "median error of the sweep", "m", 1e-4, swept.median_m));
  rows.push_back(make_row(name, "share of the surface", "", 0.5, swept.share, false));
  rows.push_back(make_row(name, "share of depths 2 mm off", "", 0.02, swept.wrong));
}

/// Where there is nothing to match, nothing may be said.
void add_silent(const std::string& name, const Swept& swept, std::vector<StabilityRow>& rows) {
  rows.push_back(make_row(name, "depths of the sweep", "", 0, swept.depths));
}

void sweep_rows(std::vector<StabilityRow>& rows) {
  for (const double offset_m : {0.0, 1e3, 1e6}) {
    const Eigen::Vector3d offset = offset_m * Eigen::Vector3d(1, -2, 0.3);
    const std::string name = offset_m == 0    ? "slanted square"
                             : offset_m < 1e4 ? "2e3 m from zero"
                                              : "2e6 m from zero";
    add_solved(name, sweep(slanted_square(1, 1, offset), volume_about(offset)), rows);
  }
  const SweepVolume volume = volume_about({0, 0, 0});
  SlantedSquare one = slanted_square();
  one.capture.frames.resize(1);
  one.poses.resize(1);
  one.depths.resize(1);
  add_silent("one view", sweep(one, volume), rows);
  SlantedSquare same = slanted_square();
  for (std::size_t i = 1; i < kViews; ++i) {
    same.capture.frames[i].sensors[0] = same.capture.frames[0].sensors[0];
    same.poses[i].camera_from_world = same.poses[0].camera_from_world;
  }
  add_silent("the same view six times", sweep(same, volume), rows);
  // The square's outline on black is all that there is to match.
  rows.push_back(make_row("no texture", "share of the surface", "", 0.03,
                          sweep(slanted_square(0), volume).share));
  SlantedSquare black = slanted_square();
  for (Frame& frame : black.capture.frames)
    frame.sensors[0].color = Image<Rgb8>(kWidth, kHeight, {0, 0, 0});
  add_silent("black photographs", sweep(black, volume), rows);
  SlantedSquare wrong = slanted_square();
  for (std::size_t i = 0; i < kViews; ++i) {  // each half a radian about its own axis, in turn
    const Eigen::AngleAxisd turn(i % 2 == 0 ? 0.5 : -0.5, Eigen::Vector3d::UnitZ());
    Pose& pose = wrong.poses[i].camera_from_world;
    pose.rotation = turn * pose.rotation;
    pose.translation_m = turn * pose.translation_m;
  }
  rows.push_back(make_row("views turned by half a radian", "share of the surface", "", 0.02,
                          sweep(wrong, volume).share));
}

/// The largest angle between normals and the square's, and the largest distance from its plane.
struct Fused {
  double points = 0;
  double angle_rad = 0, off_m = 0;
};
Fused measured(const Cloud& cloud, const Eigen::Vector3d& offset_m = Eigen::Vector3d::Zero()) {
  Fused fused;
  for (const CloudPoint& point : cloud) {
    const Eigen::Vector3d n = point.normal.cast<double>();
    fused.angle_rad = worse(fused.angle_rad, std::atan2(n.cross(kNormal).norm(), n.dot(kNormal)));
    fused.off_m =
        worse(fused.off_m, std::abs(kNormal.dot(point.position_m.cast<double>() - offset_m)));
    ++fused.points;
  }
  return fused;
}

Cloud fused_cloud(const SlantedSquare& square, const FuseConfig& config = {}) {
  const GreenConfig nothing_is_green{.hue_low = 1, .hue_high = 0};
  return fuse_depths(square.capture, square.poses, square.depths, nothing_is_green, config);
}

/// The largest distance between the points of two clouds, in any order; infinite if not as many.
double apart_m(Cloud a, Cloud b) {
  if (a.size() != b.size()) return std::numeric_limits<double>::infinity();
  const auto before = [](const CloudPoint& p, const CloudPoint& q) {
    return std::lexicographical_compare(p.position_m.begin(), p.position_m.end(),
                                        q.position_m.begin(), q.position_m.end());
  };
  std::sort(a.begin(), a.end(), before);
  std::sort(b.begin(), b.end(), before);
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = worse(most, static_cast<double>((a[i].position_m - b[i].position_m).norm()));
  return most;
}

void fusion_rows(std::vector<StabilityRow>& rows) {
  const Cloud plain = fused_cloud(slanted_square());
  for (const double offset_m : {0.0, 1.0, 100.0, 150.0}) {
    const Eigen::Vector3d offset = offset_m * Eigen::Vector3d(1, -2, 0.3);
    const Fused fused = measured(fused_cloud(slanted_square(1, 1, offset)), offset);
    const std::string name = "fused, " + std::to_string(static_cast<int>(2 * offset_m)) + " m off";
    // Floats 300 m from zero are 0.03 mm apart, over windows of 2.4 mm.
    rows.push_back(make_row(name, "largest angle of a normal", "rad", 0.03, fused.angle_rad));
    rows.push_back(make_row(name, "largest distance from the plane", "m", 5e-5, fused.off_m));
    rows.push_back(make_row(name, "share of the points of 0 m", "", 0.9,
                            fused.points / static_cast<double>(plain.size()), false));
  }
  double refused = 0;
  for (const double offset_m : {1e3, 1e6, 1e30}) {
    try {
      (void)fused_cloud(slanted_square(1, 1, offset_m * Eigen::Vector3d(1, -2, 0.3)));
    } catch (const std::invalid_argument& error) {
      refused += std::string(error.what()).find("move the origin") != std::string::npos ? 1 : 0;
    }
  }
  rows.push_back(make_row("fused, 2e3, 2e6 and 2e30 m off", "refused of 3", "", 3, refused, false));
  FuseConfig large;
  large.voxel_m *= 100;
  large.agreement_m *= 100;
  Cloud scaled = fused_cloud(slanted_square(1, 100), large);
  for (CloudPoint& point : scaled) point.position_m *= 0.01F;
  rows.push_back(make_row("fused, scene times 100", "largest distance from the plane", "m", 1e-6,
                          measured(scaled).off_m));
  rows.push_back(make_row("fused, scene times 100", "share of the points", "", 0.95,
                          static_cast<double>(scaled.size()) / static_cast<double>(plain.size()),
                          false));
  SlantedSquare holes = slanted_square();
  for (FrameDepth& depth : holes.depths) {
    for (std::size_t i = 0; i < depth.depth_m.size(); i += 3) depth.depth_m.data()[i] = kNan;
    depth.depth_m(kWidth / 2, kHeight / 2) = std::numeric_limits<float>::infinity();
    depth.depth_m(kWidth / 2 + 1, kHeight / 2) = -1;
    depth.depth_m(kWidth / 2, kHeight / 2 + 1) = 1e30F;
  }
  const Fused pierced = measured(fused_cloud(holes));
  rows.push_back(
      make_row("fused, a third NaN", "largest distance from the plane", "m", 1e-6, pierced.off_m));
  rows.push_back(make_row("fused, a third NaN", "share of the points", "", 0.6,
                          pierced.points / static_cast<double>(plain.size()), false));
  SlantedSquare turned = slanted_square();
  std::reverse(turned.capture.frames.begin(), turned.capture.frames.end());
  std::reverse(turned.poses.begin(), turned.poses.end());
  std::reverse(turned.depths.begin(), turned.depths.end());
  rows.push_back(make_row("fused, views in another order", "largest distance of a point", "m", 1e-6,
                          apart_m(fused_cloud(turned), plain)));
  SlantedSquare blind = slanted_square();
  for (FrameDepth& depth : blind.depths)
    std::fill(depth.depth_m.begin(), depth.depth_m.end(), kNan);
  rows.push_back(
      make_row("fused, all NaN", "points", "", 0, static_cast<double>(fused_cloud(blind).size())));
}

}  // namespace

std::vector<StabilityRow> depth_cases() {
  std::vector<StabilityRow> rows;
  sweep_rows(rows);
  fusion_rows(rows);
  return rows;
}

}  // namespace cousin
