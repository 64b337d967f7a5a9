#include "perception/stem/stem_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "calibration/bundle/triangulation.h"
#include "perception/stem/stem_problem.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Adds what all lengths of a plant have in common: the scale.
void add_scale(const StemFitConfig& config, StemNodes& nodes) {
  const auto n = static_cast<Eigen::Index>(nodes.nodes_m.size());
  VectorXd value(4 * n);
  for (Eigen::Index i = 0; i < n; ++i)
    value.segment<4>(4 * i) << nodes.nodes_m[static_cast<std::size_t>(i)],
        nodes.along_m[static_cast<std::size_t>(i)];
  nodes.covariance_m2 +=
      config.calibration_share * config.calibration_share * value * value.transpose();
}

StemNodes as_nodes(const StemProblem& p, const StemSolution& solution, std::vector<int> places) {
  StemNodes result;
  result.places = std::move(places);
  const std::size_t n = p.sightings.size();
  const auto numbers = [&](const VectorXd& at) {
    VectorXd value(4 * static_cast<Eigen::Index>(n));
    for (std::size_t i = 0; i < n; ++i)
      value.segment<4>(4 * static_cast<Eigen::Index>(i)) << p.node_m(at, i), p.along_m(at, i);
    return value;
  };
  const VectorXd value = numbers(solution.at);
  for (std::size_t i = 0; i < n; ++i) {
    result.nodes_m.push_back(value.segment<3>(4 * static_cast<Eigen::Index>(i)));
    result.along_m.push_back(value(4 * static_cast<Eigen::Index>(i) + 3));
  }
  const MatrixXd slope = slopes(numbers, solution.at, value.size());
  const auto unknown_shifts = std::count_if(p.sightings.begin(), p.sightings.end(),
                                            [](const StemSighting& s) { return !s.shifted_px; });
  const auto freedoms = std::max<Eigen::Index>(
      1, solution.residual.size() - p.unknowns() - static_cast<Eigen::Index>(unknown_shifts));
  const double misfit = solution.residual.squaredNorm() / static_cast<double>(freedoms);
  result.residual_sigmas = std::sqrt(misfit);
  result.covariance_m2 = std::max(1.0, misfit) * slope * solution.covariance * slope.transpose();
  const Eigen::Matrix3d across =
      p.config.scatter_m * p.config.scatter_m *
      (Eigen::Matrix3d::Identity() - p.frame.up * p.frame.up.transpose());
  // Pixels place a node that is beside the smooth stem as far along it as its line of sight leans.
  for (std::size_t i = 0; i < n; ++i) {
    const auto at = 4 * static_cast<Eigen::Index>(i);
    const double lean = std::abs(result.nodes_m[i].normalized().dot(p.frame.up));
    const double along_m = p.config.scatter_m * lean / std::sqrt(1 - std::min(0.9, lean * lean));
    result.covariance_m2.block<3, 3>(at, at) +=
        across + along_m * along_m * p.frame.up * p.frame.up.transpose();
    result.covariance_m2(at + 3, at + 3) += along_m * along_m;
  }
  add_scale(p.config, result);
  result.status = FitStatus::ok;
  return result;
}

StemNodes none(FitStatus status, std::string reason) {
  StemNodes result;
  result.status = status;
  result.reason = std::move(reason);
  return result;
}

/// Places of the sightings whose rays meet before the eyes.
std::vector<int> usable(const EyePair& eyes, std::span<const StemSighting> sightings) {
  std::vector<int> places;
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    if (first_guess(eyes, sightings[i])) places.push_back(static_cast<int>(i));
  }
  return places;
}

/// The node that fits worst, in deviations; -1 if none is beyond the limit.
int worst_node(const VectorXd& residual, std::size_t nodes, double most_sigmas) {
  int worst = -1;
  double most = most_sigmas * most_sigmas;
  for (std::size_t i = 0; i < nodes; ++i) {
    const double squares =
        residual.segment<kPerNode>(kPerNode * static_cast<Eigen::Index>(i)).squaredNorm();
    if (squares <= most) continue;
    most = squares;
    worst = static_cast<int>(i);
  }
  return worst;
}

/// The matched shift that fits worst; -1 if all fit. A window may show a leaf before the stem.
int worst_shift(const VectorXd& residual, std::size_t nodes) {
  constexpr double kMost = 3;
  int worst = -1;
  double most = kMost;
  for (std::size_t i = 0; i < nodes; ++i) {
    const double off = std::abs(residual(kPerNode * static_cast<Eigen::Index>(i) + 4));
    if (off <= most) continue;
    most = off;
    worst = static_cast<int>(i);
  }
  return worst;
}

std::string disagreement(double residual_sigmas) {
  char text[120];
  std::snprintf(text, sizeof text,
                "the images disagree: no stem is within %.1f deviations of all nodes",
                residual_sigmas);
  return text;
}

/// Sums of chords from the first node.
void add_chords(StemNodes& nodes) {
  double sum_m = 0;
  for (std::size_t i = 0; i < nodes.nodes_m.size(); ++i) {
    if (i > 0) sum_m += (nodes.nodes_m[i] - nodes.nodes_m[i - 1]).norm();
    nodes.along_m.push_back(sum_m);
  }
}

PointSighting sighting_of(const Lens& lens, const Pose& pose, const EyeNode& node,
                          double extra_x_px) {
  PointSighting s;
  s.lens = lens.camera();
  s.camera_from_world = pose;
  s.pixel_px = node.pixel_px;
  const double variance = node.sigma_px * node.sigma_px + 1e-4;
  s.covariance_px2 << variance + extra_x_px * extra_x_px, 0, 0, variance;
  return s;
}

}  // namespace

Fields fields(StemFitConfig& c) {
  return {
      {"common_share", &c.common_share, "share of a node's variance that both eyes have in common",
       0, 0.999},
      {"calibration_px", &c.calibration_px,
       "deviation of the right image's offset from its calibration, each axis", 0, 100},
      {"calibration_share", &c.calibration_share,
       "deviation of the scale of lengths by focal length and baseline", 0, 1},
      {"shift_bias_px", &c.shift_bias_px, "deviation of what all matched shifts of a plant are off",
       0, 100},
      {"bend_rad", &c.bend_rad, "deviation of a stem's turn between its ends", 1e-3, 3},
      {"lean_rad", &c.lean_rad, "deviation of its lean from where the image is upright", 0.01, 1.5},
      {"upright_rad", &c.upright_rad, "and from where the ground says that it is", 0.01, 1.5},
      {"scatter_m", &c.scatter_m, "deviation of a node from the smooth stem", 0, 0.1},
      {"most_sigmas", &c.most_sigmas, "a node farther from the stem is left out", 1, 100},
      {"most_residual_sigmas", &c.most_residual_sigmas,
       "RMS of the residuals beyond which the images disagree", 1, 100},
      {"motion_m_per_s", &c.motion_m_per_s,
       "speed of plants between exposures that are not at once", 0, 100}};
}

void validate(const StemFitConfig& config) {
  StemFitConfig copy = config;
  check_limits(fields(copy), "stem");
}

StemNodes nodes_by_middle(const EyePair& eyes, std::span<const StemSighting> sightings) {
  StemNodes result;
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    const auto node = middle_of_rays(eyes, sightings[i].left.pixel_px, sightings[i].right.pixel_px);
    if (!node) continue;
    result.places.push_back(static_cast<int>(i));
    result.nodes_m.push_back(*node);
  }
  if (result.nodes_m.empty()) return none(FitStatus::degenerate, "no rays meet before the eyes");
  add_chords(result);
  result.status = FitStatus::ok;
  return result;
}

StemNodes nodes_by_pixels(const EyePair& eyes, std::span<const StemSighting> sightings,
                          const StemFitConfig& config, double apart_s) {
  StemNodes result;
  std::vector<Eigen::Matrix3d> own;
  std::vector<Vector3d> by_offset;  // of one pixel of the right image's offset
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    const StemSighting& s = sightings[i];
    const auto near_m = middle_of_rays(eyes, s.left.pixel_px, s.right.pixel_px);
    if (!near_m) continue;
    const double moved_px = motion_px(eyes, config, near_m->z(), apart_s);
    std::vector<PointSighting> seen = {
        sighting_of(eyes.left, Pose{}, s.left, 0),
        sighting_of(eyes.right, eyes.right_from_left, s.right, moved_px)};
    // How the eyes disagree is a question of the calibration, asked over all matches.
    const TriangulationConfig all{.min_depth_sigmas = 2, .max_residual_sigmas = 1e9};
    const Triangulation node = triangulate(seen, all);
    if (node.status != TriangulationStatus::ok) continue;
    seen[1].pixel_px.x() += 1;
    const Triangulation moved = triangulate(seen, all);
    result.places.push_back(static_cast<int>(i));
    result.nodes_m.push_back(node.in_world_m);
    own.push_back(node.covariance_m2);
    by_offset.push_back(moved.status == TriangulationStatus::ok
                            ? Vector3d(moved.in_world_m - node.in_world_m)
                            : Vector3d::Zero());
  }
  if (result.nodes_m.empty()) return none(FitStatus::degenerate, "no rays meet before the eyes");
  add_chords(result);
  const auto n = static_cast<Eigen::Index>(result.nodes_m.size());
  result.covariance_m2 = MatrixXd::Zero(4 * n, 4 * n);
  VectorXd common = VectorXd::Zero(4 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    result.covariance_m2.block<3, 3>(4 * i, 4 * i) = own[k];
    common.segment<3>(4 * i) = config.calibration_px * by_offset[k];
    if (i == 0) continue;
    const Vector3d way = (result.nodes_m[k] - result.nodes_m[k - 1]).normalized();
    const Vector3d apart = common.segment<3>(4 * i) - common.segment<3>(4 * (i - 1));
    common(4 * i + 3) = common(4 * (i - 1) + 3) + way.dot(apart);
    // Chords share their nodes: what they have in common is left to the first.
    const double here = way.dot(own[k] * way) + way.dot(own[k - 1] * way);
    result.covariance_m2(4 * i + 3, 4 * i + 3) =
        result.covariance_m2(4 * (i - 1) + 3, 4 * (i - 1) + 3) + here;
    for (Eigen::Index j = 0; j < i; ++j) {
      result.covariance_m2(4 * i + 3, 4 * j + 3) = result.covariance_m2(4 * j + 3, 4 * i + 3) =
          result.covariance_m2(4 * j + 3, 4 * j + 3);
    }
  }
  result.covariance_m2 += common * common.transpose();
  add_scale(config, result);
  result.status = FitStatus::ok;
  return result;
}

StemNodes nodes_on_stem(const EyePair& eyes, std::span<const StemSighting> seen,
                        const StemFitConfig& config, double apart_s, const StemUp& up) {
  std::vector<StemSighting> sightings(seen.begin(), seen.end());
  std::vector<int> places = usable(eyes, sightings);
  if (places.empty()) return none(FitStatus::degenerate, "no rays meet before the eyes");
  const std::size_t there = places.size();
  while (true) {
    if (places.size() < 2) {
      StemNodes single = nodes_by_pixels(eyes, seen.subspan(static_cast<std::size_t>(places[0]), 1),
                                         config, apart_s);
      single.places = places;
      if (single.status != FitStatus::ok) single.places.clear();
      return single;
    }
    StemProblem problem{eyes, {}, {}, {}, config, up};
    for (const int place : places)
      problem.sightings.push_back(sightings[static_cast<std::size_t>(place)]);
    const StemSolution solution = solve_stem(problem, apart_s);
    if (!solution.is_there) return none(FitStatus::not_converged, "the stem does not converge");
    if (const int off = worst_shift(solution.residual, places.size()); off >= 0) {
      sightings[static_cast<std::size_t>(places[static_cast<std::size_t>(off)])].shifted_px.reset();
      continue;
    }
    const int worst = worst_node(solution.residual, places.size(), config.most_sigmas);
    if (worst >= 0 && places.size() >= 4) {
      places.erase(places.begin() + worst);
      continue;
    }
    StemNodes result = as_nodes(problem, solution, places);
    // Where most are no node of the stem that the others make, neither may be it.
    const bool is_most = 5 * places.size() >= 3 * there;
    if (result.residual_sigmas > config.most_residual_sigmas || !is_most)
      return none(FitStatus::not_converged,
                  disagreement(is_most ? result.residual_sigmas : config.most_sigmas));
    return result;
  }
}

StemLength chord(const StemNodes& nodes, std::size_t from, std::size_t to) {
  const Vector3d apart = nodes.nodes_m.at(to) - nodes.nodes_m.at(from);
  StemLength length{apart.norm(), kNaN};
  if (nodes.covariance_m2.size() == 0 || !(length.value_m > 0)) return length;
  const auto a = 4 * static_cast<Eigen::Index>(from), b = 4 * static_cast<Eigen::Index>(to);
  const MatrixXd& c = nodes.covariance_m2;
  const Eigen::Matrix3d between =
      c.block<3, 3>(a, a) + c.block<3, 3>(b, b) - c.block<3, 3>(a, b) - c.block<3, 3>(b, a);
  const Vector3d way = apart / length.value_m;
  const double first = std::max(0.0, way.dot(between * way));
  const double second = std::max(0.0, between.trace() - first) / (2 * length.value_m);
  length.sigma_m = std::sqrt(first + second * second);
  return length;
}

StemLength along(const StemNodes& nodes, std::size_t from, std::size_t to) {
  StemLength length{nodes.along_m.at(to) - nodes.along_m.at(from), kNaN};
  if (nodes.covariance_m2.size() == 0) return length;
  const auto a = 4 * static_cast<Eigen::Index>(from) + 3, b = 4 * static_cast<Eigen::Index>(to) + 3;
  const MatrixXd& c = nodes.covariance_m2;
  const double variance = c(a, a) + c(b, b) - c(a, b) - c(b, a);
  length.sigma_m = std::sqrt(std::max(0.0, variance));
  return length;
}

}  // namespace cousin
