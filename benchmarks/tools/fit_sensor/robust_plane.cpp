#include "benchmarks/tools/fit_sensor/robust_plane.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace cousin {
namespace {

constexpr std::size_t kLeastSamples = 16;
constexpr std::size_t kJudges = 400;
constexpr int kTriples = 100;

double residual(const Eigen::Vector3d& plane, const PlaneSample& s) {
  return s.value - plane(0) - plane(1) * s.x - plane(2) * s.y;
}

/// Median of the absolute residuals.
double spread(const Eigen::Vector3d& plane, std::span<const PlaneSample> judges,
              std::vector<double>& scratch) {
  scratch.clear();
  for (const PlaneSample& s : judges) scratch.push_back(std::abs(residual(plane, s)));
  const auto middle = scratch.begin() + static_cast<std::ptrdiff_t>(scratch.size() / 2);
  std::nth_element(scratch.begin(), middle, scratch.end());
  return *middle;
}

/// Least squares of the samples within the gate; false if they lie on a line.
bool refine(std::span<const PlaneSample> samples, double gate_px, Eigen::Vector3d& plane) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const PlaneSample& s : samples) {
    const double r = residual(plane, s);
    if (std::abs(r) > gate_px) continue;
    const Eigen::Vector3d row(1, s.x, s.y);
    a += row * row.transpose();
    b += r * row;
  }
  const Eigen::FullPivLU<Eigen::Matrix3d> solver(a);
  if (solver.rank() < 3) return false;
  plane += solver.solve(b);
  return true;
}

}  // namespace

RobustPlane fit_robust_plane(std::span<const PlaneSample> samples, double gate_px, Rng rng) {
  RobustPlane out;
  if (samples.size() < kLeastSamples) return out;
  std::vector<PlaneSample> judges;
  for (std::size_t i = 0; i < std::min(kJudges, samples.size()); ++i)
    judges.push_back(samples[uniform_index(rng, samples.size())]);
  std::vector<double> scratch;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kTriples; ++k) {
    Eigen::Matrix3d rows;
    Eigen::Vector3d values;
    for (int i = 0; i < 3; ++i) {
      const PlaneSample& s = samples[uniform_index(rng, samples.size())];
      rows.row(i) << 1, s.x, s.y;
      values(i) = s.value;
    }
    const Eigen::FullPivLU<Eigen::Matrix3d> solver(rows);
    if (solver.rank() < 3) continue;
    const Eigen::Vector3d plane = solver.solve(values);
    const double found = spread(plane, judges, scratch);
    if (found < least) {
      least = found;
      out.coefficients = plane;
    }
  }
  if (!std::isfinite(least)) return out;
  // The plane of a triple is as noisy as its points: the first gate is wide.
  constexpr double kSigmaOfMedian = 1.4826;
  for (int step = 0; step < 4; ++step) {
    out.gate_px = std::max(gate_px, 5 * kSigmaOfMedian * spread(out.coefficients, judges, scratch));
    if (!refine(samples, out.gate_px, out.coefficients)) return out;
  }
  out.found = true;
  return out;
}

}  // namespace cousin
