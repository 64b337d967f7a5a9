#include "benchmarks/suites/stability/bundle_cases.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "calibration/boards/planar_pose.h"
#include "calibration/bundle/bundle_adjustment.h"
#include "calibration/bundle/triangulation.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

Camera phone() {
  Camera camera;
  camera.model = LensModel::opencv5;
  camera.width_px = 1280;
  camera.height_px = 720;
  camera.fx_px = camera.fy_px = 1080;
  camera.cx_px = 643;
  camera.cy_px = 356;
  camera.distortion = {0.05, -0.08, 4e-4, -3e-4, 0.02};
  return camera;
}

/// What cameras at `poses` see of `points`, 0.3 px off.
BundleAdjustmentInput seen_by(const std::vector<Pose>& poses, const std::vector<Vector3d>& points,
                              Rng rng) {
  BundleAdjustmentInput input;
  input.lenses = {phone()};
  input.camera_from_world = poses;
  input.lens_of_image.assign(poses.size(), 0);
  input.points_in_world_m = points;
  const Lens lens(input.lenses[0]);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    for (std::size_t p = 0; p < points.size(); ++p) {
      const auto pixel = lens.project(poses[i] * points[p]);
      if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() > 1279 || pixel->y() > 719)
        continue;
      input.observations.push_back({static_cast<int>(i), static_cast<int>(p),
                                    *pixel + 0.3 * Vector2d(normal(rng), normal(rng)), 1});
    }
  }
  return input;
}

/// A plant of 0.2 m, cameras around it.
BundleAdjustmentInput around_a_plant() {
  Rng rng = Rng(1).fork("plant");
  std::vector<Vector3d> points;
  for (int i = 0; i < 100; ++i)
    points.emplace_back(uniform(rng, -0.1, 0.1), uniform(rng, -0.1, 0.1), uniform(rng, 0, 0.15));
  std::vector<Pose> poses;
  for (int i = 0; i < 18; ++i) {
    const double a = 20 * kDegree * i, e = 0.5 + 0.4 * (i % 3);
    poses.push_back(
        look_at(0.4 * Vector3d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)),
                Vector3d(0, 0, 0.05)));
  }
  return seen_by(poses, points, rng.fork("noise"));
}

/// A flat bench under a gantry that looks straight down.
struct Bench {
  BundleAdjustmentInput input;
  std::vector<Vector3d> truth;
};
Bench under_a_gantry() {
  Bench bench;
  Rng rng = Rng(2).fork("bench");
  for (int i = 0; i < 200; ++i)
    bench.truth.emplace_back(uniform(rng, -0.5, 0.5), uniform(rng, -0.3, 0.3), 0);
  std::vector<Pose> poses;
  for (int i = 0; i < 35; ++i) {
    Pose pose;
    pose.rotation = Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX());
    const Vector3d eye(0.12 * (i % 7) - 0.36, 0.1 * (i / 7) - 0.2, 0.5);
    pose.translation_m = -(pose.rotation * eye);
    poses.push_back(pose);
  }
  bench.input = seen_by(poses, bench.truth, rng.fork("noise"));
  return bench;
}

BundleAdjustmentInput moved(BundleAdjustmentInput input, double scale, const Vector3d& shift,
                            const Eigen::Quaterniond& turn) {
  for (Vector3d& p : input.points_in_world_m) p = scale * (turn * p) + shift;
  for (Pose& pose : input.camera_from_world) {
    pose.rotation = pose.rotation * turn.conjugate();
    pose.translation_m = scale * pose.translation_m - pose.rotation * shift;
  }
  return input;
}

/// Largest distance of a point from the reference's, taken back, over the scene's size of 0.2 m.
void add_gauge_rows(std::vector<StabilityRow>& rows) {
  const BundleAdjustmentInput input = around_a_plant();
  const BundleAdjustmentResult reference = adjust_bundle(input);
  const Eigen::Quaterniond turn = exp_rotation({0.3, -1.1, 0.7});
  struct Case {
    const char* name;
    double scale, far;
  };
  // Offsets of 1e6 scene sizes leave 10 digits of a double for the scene.
  for (const Case& c :
       {Case{"bundle in micrometres", 1e6, 0}, Case{"bundle in kilometres", 1e-3, 0},
        Case{"bundle turned at random", 1, 0},
        Case{"bundle 1000 scene sizes from the origin", 1, 200},
        Case{"bundle 1e6 scene sizes from the origin", 1, 2e5}}) {
    const Vector3d shift = c.scale * c.far * Vector3d(0.6, -0.7, 0.4);
    const BundleAdjustmentResult result = adjust_bundle(moved(input, c.scale, shift, turn));
    double worst = result.status == CalibrationStatus::ok ? 0 : kNoNumber;
    for (std::size_t p = 0; p < input.points_in_world_m.size(); ++p) {
      const Vector3d back = turn.conjugate() * (result.points_in_world_m.at(p) - shift) / c.scale;
      worst = worse(worst, (back - reference.points_in_world_m.at(p)).norm() / 0.2);
    }
    rows.push_back(make_row(c.name, "largest change of a point, over the scene's size", "",
                            c.far > 1e4 ? 1e-7 : 1e-8, worst));
  }
}

/// Height over the best plane that a bowl z = c r^2 gives at the bench's corner.
double doming_m(const std::vector<Vector3d>& points, const std::vector<Vector3d>& truth) {
  Eigen::MatrixXd a(points.size(), 4);
  Eigen::VectorXd z(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double r2 = truth[i].head<2>().squaredNorm();
    a.row(row) << 1, truth[i].x(), truth[i].y(), r2;
    z[row] = points[i].z();
  }
  const Eigen::VectorXd fit = a.colPivHouseholderQr().solve(z);
  return std::abs(fit[3]) * (0.5 * 0.5 + 0.3 * 0.3);
}

void add_gantry_rows(std::vector<StabilityRow>& rows) {
  const Bench bench = under_a_gantry();
  const BundleAdjustmentResult free = adjust_bundle(bench.input);
  rows.push_back(make_row("parallel views of a flat bench, free lens", "says not_determined", "", 1,
                          free.status == CalibrationStatus::not_determined, false));
  rows.push_back(make_row(
      "parallel views of a flat bench, free lens", "names the focal length", "", 1,
      std::count(free.not_determined.begin(), free.not_determined.end(), "lens0.fx_px") > 0,
      false));
  BundleAdjustmentConfig fixed;
  fixed.fixed = {"lens"};
  BundleAdjustmentInput wrong = bench.input;
  wrong.lenses[0].distortion[0] += 0.02;
  rows.push_back(make_row("flat bench, lens given with k1 .02 off", "doming at the corner", "m",
                          kNoNumber,
                          doming_m(adjust_bundle(wrong, fixed).points_in_world_m, bench.truth)));
  const BundleAdjustmentResult given = adjust_bundle(bench.input, fixed);
  rows.push_back(make_row("flat bench, lens given", "doming at the corner", "m", 1e-3,
                          doming_m(given.points_in_world_m, bench.truth)));
  // What a user can do about it: corners of known place.
  BundleAdjustmentInput controlled = bench.input;
  for (int p = 0; p < 30; ++p)
    controlled.known_points.push_back({p, bench.truth[static_cast<std::size_t>(p)], 1e-5});
  const BundleAdjustmentResult metric = adjust_bundle(controlled);
  rows.push_back(make_row("flat bench, free lens, 30 known points", "doming at the corner", "m",
                          1e-3, doming_m(metric.points_in_world_m, bench.truth)));
}

/// Two cameras that see a point 1 m away under an angle.
std::vector<PointSighting> pair_of(double parallax_rad, double sigma_px, Rng& rng) {
  std::vector<PointSighting> sightings;
  for (const double side : {-1.0, 1.0}) {
    PointSighting s;
    s.lens = phone();
    s.camera_from_world.translation_m.x() = -side * std::tan(0.5 * parallax_rad);
    s.pixel_px = *project(s.lens, s.camera_from_world * Vector3d(0.05, 0.02, 1)) +
                 sigma_px * Vector2d(normal(rng), normal(rng));
    s.covariance_px2 = sigma_px * sigma_px * Eigen::Matrix2d::Identity();
    sightings.push_back(s);
  }
  return sightings;
}

void add_parallax_rows(bool quick, std::vector<StabilityRow>& rows) {
  const int pairs = quick ? 500 : 5000;
  for (const double degrees : {10.0, 1.0, 0.1, 0.01}) {
    Rng rng = Rng(3).fork("pairs");
    constexpr double kSigma_px = 0.1;
    std::vector<double> normalised;
    int ok = 0, infinite = 0;
    for (int i = 0; i < pairs; ++i) {
      const Triangulation found = triangulate(pair_of(degrees * kDegree, kSigma_px, rng));
      if (found.status != TriangulationStatus::ok) continue;
      ++ok;
      infinite += !found.in_world_m.allFinite();
      normalised.push_back(std::abs(found.in_world_m.z() - 1) /
                           std::sqrt(found.covariance_m2(2, 2)));
    }
    const std::string name = "triangulation under " + std::to_string(degrees).substr(0, 5) + " deg";
    rows.push_back(
        make_row(name, "share said to be solved", "", kNoNumber, static_cast<double>(ok) / pairs));
    rows.push_back(make_row(name, "infinite among them", "", 0, infinite));
    // At 0.01 degrees, 0.1 px and f = 1080 px the depth is 1.3 sigmas from infinity: hardly any is
    // said to be solved, and those are the lucky ones.
    if (ok < pairs / 2) continue;
    std::sort(normalised.begin(), normalised.end());
    rows.push_back(make_row(name, "median error over predicted sigma, from .674", "", 0.1,
                            std::abs(normalised[normalised.size() / 2] - 0.674)));
  }
}

}  // namespace

std::vector<StabilityRow> bundle_cases(bool quick) {
  std::vector<StabilityRow> rows;
  if (adjust_bundle(around_a_plant()).status != CalibrationStatus::not_built) {
    add_gauge_rows(rows);
    add_gantry_rows(rows);
  }
  add_parallax_rows(quick, rows);
  return rows;
}

}  // namespace cousin
