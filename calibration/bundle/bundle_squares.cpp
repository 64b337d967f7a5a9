#include "calibration/bundle/bundle_squares.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace cousin {
namespace {

/// Points that a sighting in use shows: what is known of others says nothing of a sighting.
std::set<int> seen_points(const BundleProblem& problem) {
  std::set<int> points;
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    if (problem.used[i]) points.insert(problem.observations[i].point);
  }
  return points;
}

}  // namespace

int freedoms_of(const BundleProblem& problem) {
  const std::set<int> points = seen_points(problem);
  int coordinates =
      2 * static_cast<int>(std::count(problem.used.begin(), problem.used.end(), true));
  for (const KnownPoint& known : problem.known_points)
    coordinates += points.contains(known.point) ? 3 : 0;
  for (const KnownDistance& known : problem.known_distances)
    coordinates += points.contains(known.point_a) && points.contains(known.point_b) ? 1 : 0;
  int unknowns = 6 * static_cast<int>(problem.poses.size()) + 3 * static_cast<int>(points.size());
  for (const std::vector<bool>& free : problem.free)
    unknowns += static_cast<int>(std::count(free.begin(), free.end(), true));
  // A zoom is one unknown more, and what is known of it before one measurement more.
  if (problem.gauge == BundleGauge::similarity) unknowns -= 7;
  if (problem.gauge == BundleGauge::rigid) unknowns -= 6;
  return coordinates - unknowns;
}

BundleSquares squares_of(const BundleProblem& problem) {
  BundleSquares sum;
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    if (!problem.used[i]) continue;
    const Eigen::Vector2d r = bundle_residual(problem, problem.observations[i]);
    if (!r.allFinite()) continue;
    const double g = soften(problem.config.loss, problem.config.loss_px, r).factor;
    sum.softened += g * g * r.squaredNorm();
    sum.plain +=
        r.squaredNorm() * problem.observations[i].sigma_px * problem.observations[i].sigma_px;
    ++sum.points;
  }
  // These are measurements as sightings are, see freedoms_of().
  const auto point = [&](int i) { return problem.points[static_cast<std::size_t>(i)]; };
  const std::set<int> seen = seen_points(problem);
  for (const KnownPoint& known : problem.known_points) {
    if (seen.contains(known.point))
      sum.softened +=
          (point(known.point) - known.in_world_m).squaredNorm() / (known.sigma_m * known.sigma_m);
  }
  for (const KnownDistance& known : problem.known_distances) {
    if (!seen.contains(known.point_a) || !seen.contains(known.point_b)) continue;
    const double length = (point(known.point_a) - point(known.point_b)).norm();
    sum.softened += std::pow((length - known.length_m) / known.sigma_m, 2);
  }
  for (const double zoom : problem.zoom) {
    if (problem.config.zoom_share > 0)
      sum.softened += std::pow((zoom - 1) / problem.config.zoom_share, 2);
  }
  return sum;
}

double robust_sigma(const BundleProblem& problem) {
  std::vector<double> lengths;
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    if (!problem.used[i]) continue;
    const double length = bundle_residual(problem, problem.observations[i]).norm();
    if (std::isfinite(length)) lengths.push_back(length);  // else the point is behind the image
  }
  if (lengths.empty()) return 0;
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return *middle / std::sqrt(2 * std::log(2.0));
}

}  // namespace cousin
