#include <algorithm>
#include <cmath>

#include "calibration/solve/calibration_uncertainty.h"

namespace cousin {
namespace {

/// Convex hull, counter-clockwise [Andrew, Information Processing Letters 1979].
std::vector<Eigen::Vector2d> hull_of(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  std::vector<Eigen::Vector2d> hull;
  const auto turns = [&](const Eigen::Vector2d& c) {
    const Eigen::Vector2d u = hull[hull.size() - 1] - hull[hull.size() - 2];
    const Eigen::Vector2d v = c - hull[hull.size() - 2];
    return u.x() * v.y() - u.y() * v.x() > 0;
  };
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t from = hull.size();
    for (const Eigen::Vector2d& p : points) {
      while (hull.size() >= from + 2 && !turns(p)) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

/// Distance of a point outside a convex hull; 0 inside.
double outside_by(const std::vector<Eigen::Vector2d>& hull, const Eigen::Vector2d& p) {
  bool inside = hull.size() > 2;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d a = hull[i], along = hull[(i + 1) % hull.size()] - a;
    if (along.x() * (p.y() - a.y()) - along.y() * (p.x() - a.x()) < 0) inside = false;
    const double t =
        std::clamp((p - a).dot(along) / std::max(1e-12, along.squaredNorm()), 0.0, 1.0);
    nearest = std::min(nearest, (p - a - t * along).norm());
  }
  return inside ? 0 : nearest;
}

}  // namespace

ValidRegion valid_region(const CalibrationResult& result, const CalibrationInput& input, int camera,
                         const UncertaintyMap& map, double limit_px) {
  std::vector<Eigen::Vector2d> seen;
  for (const TargetView& view : input.views) {
    if (view.camera != camera || !is_usable(view)) continue;
    for (const TargetObservation& p : view.points) seen.push_back(p.pixel_px);
  }
  ValidRegion region;
  region.valid.assign(map.pixel_px.size(), false);
  if (seen.size() < 3) return region;
  const std::vector<Eigen::Vector2d> hull = hull_of(std::move(seen));
  const double margin = result.cameras.at(static_cast<std::size_t>(camera)).width_px / 20.0;
  int valid = 0;
  for (std::size_t i = 0; i < map.pixel_px.size(); ++i) {
    region.valid[i] = outside_by(hull, map.pixel_px[i]) <= margin &&
                      worst_deviation_px(map.covariance_px2[i]) <= limit_px;
    valid += region.valid[i] ? 1 : 0;
  }
  region.share = static_cast<double>(valid) / static_cast<double>(map.pixel_px.size());
  return region;
}

CrossValidation cross_validate(const CalibrationInput& input, const CalibrationConfig& config,
                               int camera) {
  std::vector<int> frames;
  for (const TargetView& view : input.views) {
    if (is_usable(view)) frames.push_back(view.frame);
  }
  std::sort(frames.begin(), frames.end());
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  CalibrationInput halves[2] = {input, input};
  for (int half = 0; half < 2; ++half) {
    std::erase_if(halves[half].views, [&](const TargetView& view) {
      const auto at = std::lower_bound(frames.begin(), frames.end(), view.frame);
      return at == frames.end() || (at - frames.begin()) % 2 != half;
    });
  }
  const CalibrationResult a = calibrate(halves[0], config), b = calibrate(halves[1], config);
  CrossValidation result;
  result.status = a.status == CalibrationStatus::ok ? b.status : a.status;
  result.reason = a.status == CalibrationStatus::ok ? b.reason : a.reason;
  const auto usable = [](CalibrationStatus status) {
    return status == CalibrationStatus::ok || status == CalibrationStatus::not_determined;
  };
  if (!usable(a.status) || !usable(b.status) || a.cameras.empty() || b.cameras.empty())
    return result;
  const auto c = static_cast<std::size_t>(camera);
  result.difference = projection_difference(a.cameras.at(c), b.cameras.at(c));
  const UncertaintyMap of_a = projection_uncertainty(a, camera);
  const UncertaintyMap of_b = projection_uncertainty(b, camera);
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < of_a.covariance_px2.size(); ++i) {
    const double trace = of_a.covariance_px2[i].trace() + of_b.covariance_px2[i].trace();
    if (std::isnan(trace)) continue;
    sum += trace;
    ++count;
  }
  result.predicted_rms_px = std::sqrt(sum / count);
  return result;
}

}  // namespace cousin
