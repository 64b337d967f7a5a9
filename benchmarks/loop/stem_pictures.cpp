#include "benchmarks/loop/stem_pictures.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <stdexcept>
#include <vector>

#include "perception/pipelines/maize.h"
#include "perception/stem/stem_seam.h"
#include "sim/geometry/measure.h"
#include "sim/imaging/image_io.h"

namespace cousin {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr Rgb8 kStemColor{255, 0, 160}, kCrossColor{0, 200, 255}, kEpipolarColor{255, 220, 0};

void draw_dot(Image<Rgb8>& image, const Vector2d& at, Rgb8 color) {
  if (!at.allFinite() || at.cwiseAbs().maxCoeff() > 1e6) return;
  const int x = static_cast<int>(std::lround(at.x())), y = static_cast<int>(std::lround(at.y()));
  if (image.contains(x, y)) image(x, y) = color;
}

void draw_line(Image<Rgb8>& image, const Vector2d& from, const Vector2d& to, Rgb8 color) {
  const int steps = std::clamp(static_cast<int>((to - from).norm() * 2), 1, 10000);
  for (int i = 0; i <= steps; ++i)
    draw_dot(image, from + (to - from) * (static_cast<double>(i) / steps), color);
}

void draw_cross(Image<Rgb8>& image, const Vector2d& at, Rgb8 color) {
  for (int k = -4; k <= 4; ++k) {
    draw_dot(image, at + Vector2d(k, 0), color);
    draw_dot(image, at + Vector2d(0, k), color);
  }
}

/// Fits of one frame.
std::vector<FittedStem> stems_of_frame(const Estimate& estimate, std::size_t place) {
  std::vector<FittedStem> stems;
  for (const ObjectFit& fit : estimate.fits) {
    if (fit.model == "stem" && fit.status == FitStatus::ok &&
        fit.instance / kPlantsOfFrame == static_cast<int>(place))
      stems.push_back(stem_of_fit(fit));
  }
  return stems;
}

/// Where the right eye sees what the left one has at a pixel, from near to far.
void draw_epipolar(Image<Rgb8>& image, const EyePair& eyes, const Vector2d& left_px) {
  const auto ray = eyes.left.unproject(left_px);
  if (!ray) return;
  for (double inverse = 0.1; inverse < 5; inverse += 0.005) {
    const auto seen = eyes.right.project(eyes.right_from_left * Vector3d(*ray / inverse));
    if (seen) draw_dot(image, *seen, kEpipolarColor);
  }
}

/// A tube of six sides along points in the world.
Mesh tube(const std::vector<Vector3d>& points_m) {
  constexpr double kRadius_m = 0.0015;
  constexpr std::uint32_t kSides = 6;
  Mesh mesh;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    const Vector3d way =
        (points_m[std::min(i + 1, points_m.size() - 1)] - points_m[i == 0 ? 0 : i - 1])
            .normalized();
    const Vector3d u = way.unitOrthogonal(), v = way.cross(u);
    for (std::uint32_t s = 0; s < kSides; ++s) {
      const double turn = 2 * 3.14159265358979 * s / kSides;
      mesh.vertices_m.push_back(points_m[i] +
                                kRadius_m * (std::cos(turn) * u + std::sin(turn) * v));
    }
    if (i == 0) continue;
    const auto base = static_cast<std::uint32_t>(kSides * i);
    for (std::uint32_t s = 0; s < kSides; ++s) {
      const std::uint32_t t = (s + 1) % kSides;
      mesh.triangles.push_back({base + s - kSides, base + t - kSides, base + s});
      mesh.triangles.push_back({base + t - kSides, base + t, base + s});
    }
  }
  return mesh;
}

Mesh stems_in_world(const Estimate& estimate, const TrueView& view, std::size_t place) {
  std::vector<Mesh> tubes;
  const Pose world_from_camera = inverse(view.camera_from_world);
  for (const FittedStem& stem : stems_of_frame(estimate, place)) {
    std::vector<Vector3d> points_m;
    for (const Vector3d& node_m : stem.nodes.nodes_m)
      points_m.push_back(world_from_camera * node_m);
    if (points_m.size() > 1) tubes.push_back(tube(points_m));
  }
  return merged(tubes);
}

}  // namespace

Image<Rgb8> stem_picture(const Capture& capture, const Frame& frame, std::size_t place,
                         const Estimate& estimate) {
  if (frame.sensors.size() < 2 || frame.sensors[0].color.empty() || frame.sensors[1].color.empty())
    throw std::invalid_argument("frame " + std::to_string(frame.id) + " has not two colour images");
  const EyePair eyes(frame.sensors[0].reported, frame.sensors[1].reported,
                     capture.rig[1].sensor_from_rig * inverse(capture.rig[0].sensor_from_rig));
  Image<Rgb8> images[2] = {frame.sensors[0].color, frame.sensors[1].color};
  for (const KeypointDetection& entry : estimate.keypoints) {
    if (entry.frame != frame.id || entry.sensor > 1) continue;
    for (const DetectedKeypoint& point : entry.points) {
      if (!point.pixel_px.allFinite()) continue;
      if (entry.sensor == 0) draw_epipolar(images[1], eyes, point.pixel_px);
      draw_cross(images[entry.sensor], point.pixel_px, kCrossColor);
    }
  }
  for (const FittedStem& stem : stems_of_frame(estimate, place)) {
    for (int eye = 0; eye < 2; ++eye) {
      std::optional<Vector2d> before;
      for (const Vector3d& node_m : stem.nodes.nodes_m) {
        const auto seen = eye == 0 ? eyes.left.project(node_m)
                                   : eyes.right.project(eyes.right_from_left * node_m);
        if (seen && before) draw_line(images[eye], *before, *seen, kStemColor);
        before = seen;
      }
    }
  }
  Image<Rgb8> both(images[0].width() + images[1].width(),
                   std::max(images[0].height(), images[1].height()));
  for (int eye = 0; eye < 2; ++eye) {
    for (int y = 0; y < images[eye].height(); ++y) {
      for (int x = 0; x < images[eye].width(); ++x)
        both(x + eye * images[0].width(), y) = images[eye](x, y);
    }
  }
  return both;
}

void show_stems(const SimulatedRun& run, const Estimate& estimate, ReportScene& scene) {
  const std::size_t count = run.capture.frames.size();
  for (const std::size_t place : std::set{std::size_t{0}, count / 2}) {
    if (place >= count || stems_of_frame(estimate, place).empty()) continue;
    const Frame& frame = run.capture.frames[place];
    if (frame.sensors.size() < 2 || frame.sensors[1].color.empty()) continue;
    scene.pictures.push_back(
        {"Stems in view " + std::to_string(frame.id),
         "left and right eye; magenta: fitted stems; blue crosses: keypoints; yellow: epipolar "
         "lines of the left ones",
         encode_png(stem_picture(run.capture, frame, place, estimate))});
  }
  if (count == 0 || run.truth.views.empty() || stems_of_frame(estimate, 0).empty()) return;
  scene.measured = stems_in_world(estimate, run.truth.views.front(), 0);
}

}  // namespace cousin
