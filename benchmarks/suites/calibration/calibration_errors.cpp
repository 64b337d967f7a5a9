#include "benchmarks/suites/calibration/calibration_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "calibration/boards/planar_pose.h"
#include "calibration/bundle/triangulation.h"
#include "calibration/solve/calibration_uncertainty.h"

namespace cousin {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr int kLattice = 33;  ///< points along each side of the image

/// Pixels of the lattice and the true directions there.
struct Sight {
  Vector2d pixel_px;
  Vector3d direction;
};
std::vector<Sight> lattice_of(const Camera& truth) {
  const Lens lens(truth);
  std::vector<Sight> lattice;
  for (int j = 0; j < kLattice; ++j) {
    for (int i = 0; i < kLattice; ++i) {
      const Vector2d pixel(i * (truth.width_px - 1.0) / (kLattice - 1),
                           j * (truth.height_px - 1.0) / (kLattice - 1));
      if (const auto direction = lens.unproject(pixel)) lattice.push_back({pixel, *direction});
    }
  }
  return lattice;
}

/// Sideways error of ray times depth at 0.5 m.
double fruit_error_m(const std::vector<Sight>& lattice, const Camera& estimate) {
  constexpr double kDepth_m = 0.5;
  const Lens lens(estimate);
  double squares = 0;
  for (const Sight& sight : lattice) {
    const auto seen = lens.unproject(sight.pixel_px);
    if (!seen || seen->z() <= 0) return kNoNumber;
    const Vector2d error = kDepth_m * (seen->hnormalized() - sight.direction.hnormalized());
    squares += error.squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(lattice.size()));
}

constexpr double kBoard_m = 0.1;    ///< side of the seed board [Seeds, 2.2.2]
constexpr double kLength_m = 0.01;  ///< of a seed of maize

/// Views of the seed board on a ring, from where its side is .6 of the picture's shorter one, each
/// with the board elsewhere in the picture.
std::vector<Pose> ring_of_views(const Camera& truth) {
  constexpr int kViews = 12;
  const double least_side_px = std::min(truth.width_px, truth.height_px);
  const double distance_m = kBoard_m * truth.fx_px / (0.6 * least_side_px);
  std::vector<Pose> views;
  for (int i = 0; i < kViews; ++i) {
    const double azimuth = 2 * std::numbers::pi * i / kViews;
    constexpr double kElevation_rad = 0.9;
    const Vector3d from(std::cos(kElevation_rad) * std::cos(azimuth),
                        std::cos(kElevation_rad) * std::sin(azimuth), std::sin(kElevation_rad));
    Pose pose = look_at(distance_m * from, Vector3d::Zero());
    // Off the middle by a tenth of the distance, in another direction each time.
    pose.translation_m += 0.1 * distance_m * Vector3d(std::cos(2.4 * i), std::sin(2.4 * i), 0);
    views.push_back(pose);
  }
  return views;
}

double seed_error_m(const Camera& truth, const Camera& estimate) {
  const Lens true_lens(truth), lens(estimate);
  struct View {
    Pose truly, estimated;
  };
  std::vector<View> views;
  for (const Pose& truly : ring_of_views(truth)) {
    std::vector<BoardPoint> corners;
    for (int j = 0; j <= 8; ++j) {
      for (int i = 0; i <= 8; ++i) {
        const Vector3d at(kBoard_m * (i / 8.0 - 0.5), kBoard_m * (j / 8.0 - 0.5), 0);
        if (const auto pixel = true_lens.project(truly * at))
          corners.push_back({at, *pixel, 1e-4 * Eigen::Matrix2d::Identity()});
      }
    }
    const PlanarPose pose = estimate_planar_pose(estimate, corners);
    if (!pose.ok) return kNoNumber;
    views.push_back({truly, pose.camera_from_board});
  }
  const auto measured = [&](const Vector3d& point) -> std::optional<Vector3d> {
    std::vector<Vector3d> origins, ways;
    for (const View& view : views) {
      const auto pixel = true_lens.project(view.truly * point);
      const auto way = pixel ? lens.unproject(*pixel) : std::nullopt;
      if (!way) return std::nullopt;
      const Pose board_from_camera = inverse(view.estimated);
      origins.push_back(board_from_camera.translation_m);
      ways.push_back(board_from_camera.rotation * *way);
    }
    return nearest_to_lines(origins, ways);
  };
  double squares = 0;
  int count = 0;
  for (int k = 0; k < 24; ++k) {
    const double angle = 2.4 * k, from_middle = 0.035 * std::sqrt((k + 0.5) / 24.0);
    const Vector3d middle(from_middle * std::cos(angle), from_middle * std::sin(angle), 0.003);
    const Vector3d half(0.5 * kLength_m * std::cos(7.0 * k), 0.5 * kLength_m * std::sin(7.0 * k),
                        0);
    const auto a = measured(middle - half), b = measured(middle + half);
    if (!a || !b) return kNoNumber;
    const double error = (*a - *b).norm() - kLength_m;
    squares += error * error;
    ++count;
  }
  return std::sqrt(squares / count);
}

}  // namespace

CalibrationErrors calibration_errors(const Camera& truth, const Camera& estimate) {
  CalibrationErrors errors;
  const ProjectionDifference difference = projection_difference(truth, estimate);
  errors.projection_px = difference.rms_px;
  errors.projection_worst_px = difference.max_px;
  errors.fruit_m = fruit_error_m(lattice_of(truth), estimate);
  errors.seed_m = seed_error_m(truth, estimate);
  return errors;
}

}  // namespace cousin
