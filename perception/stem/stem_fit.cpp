#include "perception/stem/stem_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <stdexcept>

#include "calibration/bundle/triangulation.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kShape = 8;  ///< two cubics
constexpr int kRig = 3;    ///< the right image's offset, and of matched shifts one more

/// Deviation by which a plant that moves between exposures is beside its place in the right image.
double motion_px(const EyePair& eyes, const StemFitConfig& config, double depth_m, double apart_s) {
  return config.motion_m_per_s * std::abs(apart_s) * eyes.right.camera().fx_px /
         std::max(depth_m, 0.05);
}

// ---- Sightings
// -----------------------------------------------------------------------------------

/// The inverse root of the covariance of (left x, left y, right x, right y).
Eigen::Matrix4d whitening(const StemSighting& s, const StemFitConfig& config, double moved_px) {
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  const double both = config.common_share * s.left.sigma_px * s.right.sigma_px;
  for (int k = 0; k < 2; ++k) {
    covariance(k, k) = s.left.sigma_px * s.left.sigma_px;
    covariance(k + 2, k + 2) = s.right.sigma_px * s.right.sigma_px;
    covariance(k, k + 2) = covariance(k + 2, k) = both;
  }
  covariance(2, 2) += moved_px * moved_px;
  covariance.diagonal().array() += 1e-4;  // truth has no error at all
  const Eigen::Matrix4d root = covariance.llt().matrixL();
  return root.inverse();
}

// ---- The smooth stem
// -----------------------------------------------------------------------------

/// Axes of a stem: `up` along it in the image's plane, `depth` along the line of sight.
struct StemFrame {
  Vector3d origin_m, up, depth, side;
  double half_m = 0.02;  ///< half of its length
};

StemFrame frame_of(const std::vector<Vector3d>& points_m) {
  StemFrame frame;
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& point : points_m) middle += point / static_cast<double>(points_m.size());
  frame.origin_m = middle;
  frame.depth = middle.normalized();
  Vector3d up = points_m.back() - points_m.front();
  up -= frame.depth * frame.depth.dot(up);
  if (!(up.norm() > 1e-6)) up = Vector3d(0, -1, 0) - frame.depth * -frame.depth.y();
  frame.up = up.normalized();
  frame.side = frame.up.cross(frame.depth);
  for (const Vector3d& point : points_m)
    frame.half_m = std::max(frame.half_m, std::abs(frame.up.dot(point - middle)));
  return frame;
}

/// Everything that is solved for at once.
struct StemProblem {
  const EyePair& eyes;
  std::vector<StemSighting> sightings;
  std::vector<Eigen::Matrix4d> white;
  StemFrame frame;
  StemFitConfig config;
  StemUp up;

  Eigen::Index unknowns() const {
    return kShape + kRig + static_cast<Eigen::Index>(sightings.size());
  }
  Vector3d point_m(const VectorXd& at, double t_m) const {
    const double t = t_m / frame.half_m;
    const Eigen::Vector4d powers(1, t, t * t, t * t * t);
    return frame.origin_m + t_m * frame.up + powers.dot(at.segment<4>(0)) * frame.depth +
           powers.dot(at.segment<4>(4)) * frame.side;
  }
  double t_m(const VectorXd& at, std::size_t i) const {
    return at(kShape + kRig + static_cast<Eigen::Index>(i));
  }
  Vector3d node_m(const VectorXd& at, std::size_t i) const { return point_m(at, t_m(at, i)); }

  /// Arc from the first node: Simpson's rule over eight pieces.
  double along_m(const VectorXd& at, std::size_t i) const {
    constexpr int kPieces = 8;
    const double from = t_m(at, 0), step = (t_m(at, i) - from) / kPieces;
    double length_m = 0;
    for (int k = 0; k < kPieces; ++k)
      length_m += (point_m(at, from + (k + 1) * step) - point_m(at, from + k * step)).norm();
    return step < 0 ? -length_m : length_m;
  }
};

constexpr Eigen::Index kPerNode = 5;

/// Slopes of a stem that grows straight up, along the line of sight and to the side.
Eigen::Vector2d upright_slopes(const StemProblem& p) {
  const double along = p.up.up.dot(p.frame.up);
  if (along < 0.2) return Eigen::Vector2d::Zero();
  return {p.up.up.dot(p.frame.depth) / along, p.up.up.dot(p.frame.side) / along};
}

/// Whitened residuals: five of each node, then the priors. Empty where a node is behind an eye.
VectorXd residuals(const StemProblem& p, const VectorXd& at) {
  const auto n = static_cast<Eigen::Index>(p.sightings.size());
  VectorXd r = VectorXd::Zero(kPerNode * n + kShape - 2 + kRig);
  const Vector2d offset_px = at.segment<2>(kShape);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const StemSighting& s = p.sightings[k];
    const Vector3d node_m = p.node_m(at, k);
    const auto left = p.eyes.left.project(node_m);
    const auto right = p.eyes.right.project(p.eyes.right_from_left * node_m);
    if (!left || !right) return {};
    Eigen::Vector4d off;
    off << *left - s.left.pixel_px, *right + offset_px - s.right.pixel_px;
    r.segment<4>(kPerNode * i) = p.white[k] * off;
    if (s.shifted_px) {
      const double seen_px = s.shifted_px->x() - s.left.pixel_px.x();
      r(kPerNode * i + 4) =
          (right->x() + offset_px.x() + at(kShape + 2) - left->x() - seen_px) / s.shift_sigma_px;
    }
  }
  Eigen::Index row = kPerNode * n;
  const double half = p.frame.half_m, bend_m = 0.25 * p.config.bend_rad * half;
  const Eigen::Vector2d lean = upright_slopes(p);
  const double lean_tan = std::tan(p.up.is_of_ground ? p.config.upright_rad : p.config.lean_rad);
  r(row++) = (at(1) / half - lean.x()) / lean_tan;
  r(row++) = at(2) / bend_m;
  r(row++) = at(3) / bend_m;
  r(row++) = (at(5) / half - lean.y()) / lean_tan;
  r(row++) = at(6) / bend_m;
  r(row++) = at(7) / bend_m;
  r.segment<2>(row) = offset_px / std::max(1e-3, p.config.calibration_px);
  r(row + 2) = at(kShape + 2) / std::max(1e-3, p.config.shift_bias_px);
  return r;
}

/// Central differences of a vector of numbers at `at`.
MatrixXd slopes(const std::function<VectorXd(const VectorXd&)>& numbers, const VectorXd& at,
                Eigen::Index count) {
  MatrixXd slope(count, at.size());
  for (Eigen::Index k = 0; k < at.size(); ++k) {
    const double step = 1e-6;
    VectorXd high = at, low = at;
    high(k) += step;
    low(k) -= step;
    const VectorXd above = numbers(high), below = numbers(low);
    if (above.size() != count || below.size() != count) return {};
    slope.col(k) = (above - below) / (2 * step);
  }
  return slope;
}

struct StemSolution {
  bool is_there = false;
  VectorXd at;
  MatrixXd covariance;
  VectorXd residual;
};

/// Levenberg-Marquardt.
StemSolution solve(const StemProblem& p, VectorXd at) {
  StemSolution solution;
  VectorXd here = residuals(p, at);
  if (here.size() == 0) return solution;
  const auto numbers = [&p](const VectorXd& x) { return residuals(p, x); };
  MatrixXd normal;
  double damping = 1e-4;
  for (int step = 0; step < 40; ++step) {
    const MatrixXd slope = slopes(numbers, at, here.size());
    if (slope.size() == 0) return solution;
    normal = slope.transpose() * slope;
    const VectorXd right = slope.transpose() * here;
    bool is_better = false;
    double moved = 0;
    for (int attempt = 0; attempt < 8 && !is_better; ++attempt) {
      MatrixXd damped = normal;
      damped.diagonal() *= 1 + damping;
      const VectorXd move = damped.ldlt().solve(right);
      const VectorXd there = residuals(p, at - move);
      is_better = there.size() > 0 && there.squaredNorm() <= here.squaredNorm() * (1 + 1e-14);
      damping = is_better ? std::max(1e-12, 0.1 * damping) : 10 * damping;
      if (!is_better) continue;
      at -= move;
      here = there;
      moved = move.cwiseAbs().maxCoeff();
    }
    if (!is_better || moved < 1e-9) break;
  }
  const Eigen::LDLT<MatrixXd> inverse(normal);
  if (inverse.info() != Eigen::Success || !inverse.isPositive()) return solution;
  solution.covariance = inverse.solve(MatrixXd::Identity(normal.rows(), normal.cols()));
  solution.is_there = solution.covariance.allFinite() && at.allFinite();
  solution.at = std::move(at);
  solution.residual = std::move(here);
  return solution;
}

/// Where a node is by itself: by its shift if there is one, which is sharper than the points.
std::optional<Vector3d> first_guess(const EyePair& eyes, const StemSighting& s) {
  if (s.shifted_px) return middle_of_rays(eyes, s.left.pixel_px, *s.shifted_px);
  return middle_of_rays(eyes, s.left.pixel_px, s.right.pixel_px);
}

StemSolution solve_stem(StemProblem& p, double apart_s) {
  std::vector<Vector3d> points_m;
  for (const StemSighting& s : p.sightings) points_m.push_back(*first_guess(p.eyes, s));
  p.frame = frame_of(points_m);
  p.white.clear();
  for (const StemSighting& s : p.sightings) {
    p.white.push_back(
        whitening(s, p.config, motion_px(p.eyes, p.config, p.frame.origin_m.z(), apart_s)));
  }
  VectorXd at = VectorXd::Zero(p.unknowns());
  at(1) = p.frame.half_m * upright_slopes(p).x();
  for (std::size_t i = 0; i < points_m.size(); ++i)
    at(kShape + kRig + static_cast<Eigen::Index>(i)) =
        p.frame.up.dot(points_m[i] - p.frame.origin_m);
  return solve(p, at);
}

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
  // A chord is never surer than its second order allows, nor is the arc above it.
  length.sigma_m = std::max(std::sqrt(std::max(0.0, variance)), 0.0);
  return length;
}

ObjectFit stem_as_fit(const StemNodes& nodes, int instance, bool has_root) {
  ObjectFit fit;
  fit.instance = instance;
  fit.model = "stem";
  fit.status = nodes.status;
  fit.reason = nodes.reason;
  if (nodes.status != FitStatus::ok) return fit;
  const bool root_kept = has_root && nodes.places.front() == 0;
  for (std::size_t i = 0; i < nodes.nodes_m.size(); ++i) {
    const std::string name = "node_" + std::to_string(root_kept ? i : i + 1) + "_";
    const char* const axes[] = {"x", "y", "z"};
    for (int k = 0; k < 3; ++k)
      fit.parameters.push_back({name + axes[k], "m", nodes.nodes_m[i](k)});
    fit.parameters.push_back({name + "along", "m", nodes.along_m[i]});
  }
  fit.covariance = nodes.covariance_m2;
  return fit;
}

FittedStem stem_of_fit(const ObjectFit& fit) {
  if (fit.model != "stem")
    throw std::invalid_argument("fits.json: object " + std::to_string(fit.instance) + " is a \"" +
                                fit.model + "\", not a \"stem\"");
  FittedStem stem;
  stem.nodes.status = fit.status;
  stem.nodes.reason = fit.reason;
  if (fit.status != FitStatus::ok) return stem;
  if (fit.parameters.empty() || fit.parameters.size() % 4 != 0)
    throw std::invalid_argument("fits.json: stem " + std::to_string(fit.instance) + " has " +
                                std::to_string(fit.parameters.size()) +
                                " parameters; four are asked for each node");
  stem.has_root = fit.parameters.front().name == "node_0_x";
  for (std::size_t i = 0; i + 3 < fit.parameters.size(); i += 4) {
    stem.nodes.places.push_back(static_cast<int>(i / 4));
    stem.nodes.nodes_m.emplace_back(fit.parameters[i].value, fit.parameters[i + 1].value,
                                    fit.parameters[i + 2].value);
    stem.nodes.along_m.push_back(fit.parameters[i + 3].value);
  }
  stem.nodes.covariance_m2 = fit.covariance;
  return stem;
}

}  // namespace cousin
