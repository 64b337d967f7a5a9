#include "perception/silhouette/surface_problem.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "perception/silhouette/icosphere.h"

namespace cousin {
namespace {

constexpr int kChunks = 8;          ///< of the views, for sums in a fixed order
constexpr double kTukey = 4.685;    ///< 95 % efficient for Gaussian residuals
constexpr double kOutlier = 4.5;    ///< scatters
constexpr double kWeakSigma = 0.5;  ///< prior of l <= 2: size, position and ellipsoid are free
constexpr double kLeastRadius = 0.05;

/// An outline point and where its normal meets the model.
struct Match {
  std::size_t view = 0, point = 0;
  Eigen::Vector3d u;
  Eigen::Vector2d normal;
  double residual_px = 0;  ///< along the normal, measured - model, biases not taken off
  double gain_px = 0;      ///< d(model along the normal) / d(radius)
  double sigma_px = 0;
  double normalized = 0;  ///< residual without biases over sigma
};

struct PatchResidual {
  Eigen::Vector3d u;
  double residual_m = 0, gain_m = 0, sigma_m = 0, normalized = 0;
};

double median_absolute(std::vector<double> values) {
  if (values.empty()) return 0;
  for (double& value : values) value = std::abs(value);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Tukey's biweight. Where a shadow is taken for the object, whole stretches of outline are far
/// out: a loss that never gives them up (Huber's) makes seeds a tenth of a millimetre narrower or
/// wider.
double robust_weight(double scaled_residual) {
  const double ratio = scaled_residual / kTukey;
  if (std::abs(ratio) >= 1) return 0;
  const double kept = 1 - ratio * ratio;
  return kept * kept;
}

/// Normal equations of (b, outline bias, cloud bias) for an increment of b and new values of the
/// biases.
struct NormalEquations {
  Eigen::MatrixXd h;  ///< lower triangle
  Eigen::VectorXd g;
  std::vector<Eigen::Matrix2d> h_view;
  std::vector<Eigen::MatrixXd> h_mixed;  ///< 2 x unknowns
  std::vector<Eigen::Vector2d> g_view;
};

/// What the gap under the object adds to an outline's sigma: it is as blurred as the image.
/// @param pixels_per_m  at the surface
double contact_sigma_px(const SurfaceFitConfig& config, double height_m, double pixels_per_m) {
  const double height_px = std::max(0.0, height_m) * pixels_per_m;
  return config.contact_sigma_px * std::exp(-height_px / config.contact_height_px);
}

std::vector<Match> match_views(const SurfaceProblem& problem, const SurfaceState& state,
                               const SampledSurface& surface, double limit_px) {
  std::vector<std::vector<Match>> found(problem.views.size());
  tbb::parallel_for(std::size_t{0}, problem.views.size(), [&](std::size_t v) {
    const OutlineView& view = problem.views[v];
    const Pose& camera_from_world = view.pose.camera_from_world;
    const auto contour = apparent_contour(surface, problem.basis.sphere.vertices_m, view.pose);
    for (std::size_t p = 0; p < view.points.size(); ++p) {
      const OutlinePoint& point = view.points[p];
      const Eigen::Vector2d pixel = point.pixel_px.cast<double>(),
                            normal = point.normal.cast<double>();
      const auto crossing = cross_contour(contour, pixel, normal, limit_px);
      if (!crossing) continue;
      // The exact surface there: errors of the triangles' contour enter squared only.
      const Eigen::Vector3d& u = crossing->direction;
      Eigen::VectorXd y(problem.basis.harmonics.count());
      problem.basis.harmonics.evaluate(u, y);
      const double radius = std::max(kLeastRadius, 1 + y.dot(state.radius));
      const Eigen::Vector3d surface_m = state.frame.point_m(u, radius);
      const auto projection =
          project_with_jacobian(view.pose.camera, camera_from_world * surface_m);
      if (!projection) continue;
      Match match{v, p, u, normal};
      match.residual_px = normal.dot(pixel - projection->pixel_px);
      match.gain_px =
          normal.dot(projection->d_point * (camera_from_world.rotation * (state.frame.axes_m * u)));
      match.sigma_px = std::hypot(
          point.sigma_px,
          contact_sigma_px(problem.config, surface_m.z(), projection->d_point.row(1).norm()));
      match.normalized =
          (match.residual_px - state.outline_bias_px - normal.dot(state.view_shifts_px[v])) /
          match.sigma_px;
      found[v].push_back(match);
    }
  });
  std::vector<Match> matches;
  for (const auto& part : found) matches.insert(matches.end(), part.begin(), part.end());
  return matches;
}

std::vector<PatchResidual> patch_residuals(const SurfaceProblem& problem, const SurfaceState& state,
                                           const SampledSurface& surface) {
  const Eigen::Matrix3d u_from_world = state.frame.axes_m.inverse();
  std::vector<PatchResidual> residuals;
  for (const CloudPatch& patch : problem.patches) {
    const Eigen::Vector3d scaled = u_from_world * (patch.point_m - state.frame.centre_m);
    PatchResidual residual;
    residual.u = scaled.normalized();
    // The normal of the nearest vertex is exact enough: the error enters by its cosine.
    std::size_t nearest = 0;
    double best = -2;
    for (std::size_t i = 0; i < problem.basis.sphere.vertices_m.size(); ++i) {
      const double cosine = problem.basis.sphere.vertices_m[i].dot(residual.u);
      if (cosine > best) {
        best = cosine;
        nearest = i;
      }
    }
    Eigen::VectorXd y(problem.basis.harmonics.count());
    problem.basis.harmonics.evaluate(residual.u, y);
    residual.gain_m = surface.normals[nearest].dot(state.frame.axes_m * residual.u);
    residual.residual_m = residual.gain_m * (scaled.norm() - (1 + y.dot(state.radius)));
    residual.sigma_m = patch.sigma_m;
    residual.normalized = (residual.residual_m - state.cloud_bias_m) / residual.sigma_m;
    residuals.push_back(residual);
  }
  return residuals;
}

/// Number of neighbouring points that carry the information of one: 1 + 2 sum of the
/// autocorrelations up to the first that is not positive.
double correlation_length(const SurfaceProblem& problem, const std::vector<Match>& matches,
                          double scale) {
  constexpr int kLags = 24;
  std::vector<double> products(kLags + 1, 0.0), counts(kLags + 1, 0.0);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (std::abs(matches[i].normalized) > 3 * scale) continue;
    for (std::size_t j = i; j < matches.size() && matches[j].view == matches[i].view; ++j) {
      const auto& positions = problem.views[matches[i].view].positions;
      const int lag = positions[matches[j].point] - positions[matches[i].point];
      if (lag > kLags) break;
      if (std::abs(matches[j].normalized) > 3 * scale) continue;
      products[static_cast<std::size_t>(lag)] += matches[i].normalized * matches[j].normalized;
      counts[static_cast<std::size_t>(lag)] += 1;
    }
  }
  if (products[0] <= 0) return 1;
  double length = 1;
  for (std::size_t lag = 1; lag <= kLags && counts[lag] > 0; ++lag) {
    const double correlation = (products[lag] / counts[lag]) / (products[0] / counts[0]);
    if (correlation <= 0.05) break;
    length += 2 * correlation;
  }
  return length;
}

/// Scatter of both kinds of residuals; `scale` is read by the robust weights of the same step.
void update_scale(const SurfaceProblem& problem, const std::vector<Match>& matches,
                  const std::vector<PatchResidual>& patches, ResidualScale& scale) {
  std::vector<double> values;
  for (const Match& match : matches) values.push_back(match.normalized);
  scale.outline = std::max(0.3, 1.4826 * median_absolute(values));
  scale.correlation = correlation_length(problem, matches, scale.outline);
  double inliers = 0;
  for (const Match& match : matches)
    inliers += std::abs(match.normalized) < kOutlier * scale.outline ? 1 : 0;
  std::size_t points = 0;
  for (const OutlineView& view : problem.views) points += view.points.size();
  scale.matched =
      points > 0 ? static_cast<double>(matches.size()) / static_cast<double>(points) : 0;
  scale.inliers = matches.empty() ? 0 : inliers / static_cast<double>(matches.size());
  values.clear();
  for (const PatchResidual& patch : patches) values.push_back(patch.normalized);
  scale.cloud = std::max(0.5, 1.4826 * median_absolute(values));
}

/// Precision of the prior on each b_lm.
Eigen::VectorXd prior_precision(const SurfaceProblem& problem, double roughness) {
  Eigen::VectorXd precision(problem.basis.harmonics.count());
  for (int l = 0; l <= problem.basis.harmonics.degree(); ++l) {
    const double bending = l * (l + 1.0) / roughness;
    const double value =
        l <= 2 ? 1 / (kWeakSigma * kWeakSigma) : problem.config.smoothness * bending * bending;
    precision.segment(l * l, 2 * l + 1).setConstant(value);
  }
  return precision;
}

void add_row(NormalEquations& to, const Eigen::VectorXd& row, double residual, double weight) {
  to.h.selfadjointView<Eigen::Lower>().rankUpdate(row, weight);
  to.g += weight * residual * row;
}

/// The outlines' share of the equations, a chunk of views at a time.
void add_outlines(const SurfaceProblem& problem, const std::vector<Match>& matches,
                  const ResidualScale& scale, NormalEquations& to) {
  const Eigen::Index unknowns = to.g.size(), harmonics = problem.basis.harmonics.count();
  std::vector<Eigen::MatrixXd> h(kChunks);
  std::vector<Eigen::VectorXd> g(kChunks);
  // Views in contiguous chunks; matches are sorted by view.
  tbb::parallel_for(0, kChunks, [&](int chunk) {
    const std::size_t count = problem.views.size();
    const std::size_t first = count * static_cast<std::size_t>(chunk) / kChunks;
    const std::size_t last = count * static_cast<std::size_t>(chunk + 1) / kChunks;
    const auto by_view = [](const Match& match, std::size_t view) { return match.view < view; };
    const auto begin = std::lower_bound(matches.begin(), matches.end(), first, by_view);
    const auto end = std::lower_bound(matches.begin(), matches.end(), last, by_view);
    Eigen::MatrixXd rows(unknowns, end - begin);  // a column a match, times the root of its weight
    Eigen::VectorXd residuals(end - begin), y(harmonics);
    rows.setZero();
    Eigen::Index at = 0;
    for (auto match = begin; match != end; ++match, ++at) {
      const double variance =
          match->sigma_px * match->sigma_px * scale.outline * scale.outline * scale.correlation;
      const double weight = robust_weight(match->normalized / scale.outline) / variance;
      const double root = std::sqrt(weight);
      problem.basis.harmonics.evaluate(match->u, y);
      rows.col(at).head(harmonics) = root * match->gain_px * y;
      rows(harmonics, at) = root;
      residuals[at] = root * match->residual_px;
      to.h_view[match->view] += weight * match->normal * match->normal.transpose();
      to.h_mixed[match->view] += root * match->normal * rows.col(at).transpose();
      to.g_view[match->view] += weight * match->residual_px * match->normal;
    }
    auto& sum = h[static_cast<std::size_t>(chunk)];
    sum = Eigen::MatrixXd::Zero(unknowns, unknowns);
    g[static_cast<std::size_t>(chunk)] = Eigen::VectorXd::Zero(unknowns);
    if (begin == end) return;
    sum.selfadjointView<Eigen::Lower>().rankUpdate(rows);
    g[static_cast<std::size_t>(chunk)] = rows * residuals;
  });
  for (int chunk = 0; chunk < kChunks; ++chunk) {
    to.h += h[static_cast<std::size_t>(chunk)];
    to.g += g[static_cast<std::size_t>(chunk)];
  }
}

/// What a step of b does to the heights of the vertices that may meet the board.
struct BoardContact {
  Eigen::MatrixXd rows;  ///< d(height) / d(unknowns), a column a vertex
  Eigen::VectorXd heights_m;
};

/// Vertices higher than this are not looked at.
constexpr double kContactReach_m = 5e-4;

BoardContact contact_of(const SurfaceProblem& problem, const SurfaceState& state,
                        const SampledSurface& surface) {
  const auto& vertices = surface.mesh.vertices_m;
  double lowest_m = vertices[0].z();
  for (const Eigen::Vector3d& vertex : vertices) lowest_m = std::min(lowest_m, vertex.z());
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (vertices[i].z() < std::max(lowest_m, 0.0) + kContactReach_m) near.push_back(i);
  }
  const Eigen::Index harmonics = problem.basis.harmonics.count(),
                     count = static_cast<Eigen::Index>(near.size());
  BoardContact contact{Eigen::MatrixXd::Zero(harmonics + 2, count), Eigen::VectorXd(count)};
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::size_t i = near[static_cast<std::size_t>(k)];
    const double gain_m = (state.frame.axes_m * problem.basis.sphere.vertices_m[i]).z();
    contact.rows.col(k).head(harmonics) =
        gain_m * problem.basis.values.row(static_cast<Eigen::Index>(i)).transpose();
    contact.heights_m[k] = vertices[i].z();
  }
  return contact;
}

/// Holds the vertices that would be under the board, or else the lowest, on it. Returns which.
std::vector<Eigen::Index> held_vertices(const Eigen::VectorXd& heights_m) {
  std::vector<Eigen::Index> held;
  for (Eigen::Index k = 0; k < heights_m.size(); ++k) {
    if (heights_m[k] < 0) held.push_back(k);
  }
  if (held.empty()) {
    Eigen::Index lowest = 0;
    heights_m.minCoeff(&lowest);
    held.push_back(lowest);
  }
  return held;
}

Eigen::MatrixXd rows_of(const BoardContact& contact, const std::vector<Eigen::Index>& held) {
  Eigen::MatrixXd rows(contact.rows.rows(), static_cast<Eigen::Index>(held.size()));
  for (std::size_t k = 0; k < held.size(); ++k)
    rows.col(static_cast<Eigen::Index>(k)) = contact.rows.col(held[k]);
  return rows;
}

/// Solves h x = g with the board as a one-sided penalty: vertices are held or let go until the
/// heights that the step leads to agree with the set. `h` holds the board's rows on return.
Eigen::VectorXd solve_on_board(Eigen::MatrixXd& h, const Eigen::VectorXd& g,
                               const BoardContact& contact, double sigma_m) {
  constexpr int kRounds = 8;
  const double weight = 1 / (sigma_m * sigma_m);
  const Eigen::MatrixXd free = h;
  std::vector<Eigen::Index> held = held_vertices(contact.heights_m);
  Eigen::VectorXd x;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::MatrixXd rows = rows_of(contact, held);
    Eigen::VectorXd right = g;
    for (std::size_t k = 0; k < held.size(); ++k) {
      right -= weight * contact.heights_m[held[k]] * rows.col(static_cast<Eigen::Index>(k));
    }
    h = free;
    h.selfadjointView<Eigen::Lower>().rankUpdate(rows, weight);
    x = h.selfadjointView<Eigen::Lower>().llt().solve(right);
    std::vector<Eigen::Index> next =
        held_vertices(contact.heights_m + contact.rows.transpose() * x);
    if (next == held) break;
    held = std::move(next);
  }
  return x;
}

NormalEquations assemble(const SurfaceProblem& problem, const SurfaceState& state,
                         const std::vector<Match>& matches,
                         const std::vector<PatchResidual>& patches, const ResidualScale& scale) {
  const SurfaceFitConfig& config = problem.config;
  const Eigen::Index harmonics = problem.basis.harmonics.count(), unknowns = harmonics + 2;
  NormalEquations equations;
  equations.h = Eigen::MatrixXd::Zero(unknowns, unknowns);
  equations.g = Eigen::VectorXd::Zero(unknowns);
  const double shift_precision = 1 / (config.view_shift_sigma_px * config.view_shift_sigma_px);
  equations.h_view.assign(problem.views.size(), shift_precision * Eigen::Matrix2d::Identity());
  equations.h_mixed.assign(problem.views.size(), Eigen::MatrixXd::Zero(2, unknowns));
  equations.g_view.assign(problem.views.size(), Eigen::Vector2d::Zero());

  add_outlines(problem, matches, scale, equations);
  Eigen::VectorXd row(unknowns), y(harmonics);
  for (const PatchResidual& patch : patches) {
    problem.basis.harmonics.evaluate(patch.u, y);
    row << patch.gain_m * y, 0, 1;
    const double variance = patch.sigma_m * patch.sigma_m * scale.cloud * scale.cloud;
    add_row(equations, row, patch.residual_m,
            robust_weight(patch.normalized / scale.cloud) / variance);
  }

  const Eigen::VectorXd precision = prior_precision(problem, state.roughness);
  equations.h.diagonal().head(harmonics) += precision;
  equations.g.head(harmonics) -= precision.cwiseProduct(state.radius);
  equations.h(harmonics, harmonics) +=
      1 / (config.outline_bias_sigma_px * config.outline_bias_sigma_px);
  equations.h(harmonics + 1, harmonics + 1) +=
      1 / (config.cloud_bias_sigma_m * config.cloud_bias_sigma_m);
  return equations;
}

/// Takes the views' shifts out (Schur complement); `h` and `g` are then those of the other unknowns
/// alone.
void eliminate_shifts(NormalEquations& equations) {
  for (std::size_t v = 0; v < equations.h_view.size(); ++v) {
    const Eigen::Matrix2d inverse = equations.h_view[v].inverse();
    const Eigen::MatrixXd& mixed = equations.h_mixed[v];
    const Eigen::Matrix2d root = Eigen::LLT<Eigen::Matrix2d>(inverse).matrixL();
    const Eigen::MatrixXd half = mixed.transpose() * root;
    equations.h.selfadjointView<Eigen::Lower>().rankUpdate(half, -1);
    equations.g -= mixed.transpose() * (inverse * equations.g_view[v]);
  }
}

}  // namespace

SurfaceBasis::SurfaceBasis(int degree, int subdivisions)
    : harmonics(degree), sphere(icosphere(subdivisions)) {
  values.resize(static_cast<Eigen::Index>(sphere.vertices_m.size()), harmonics.count());
  Eigen::VectorXd y(harmonics.count());
  for (std::size_t i = 0; i < sphere.vertices_m.size(); ++i) {
    harmonics.evaluate(sphere.vertices_m[i], y);
    values.row(static_cast<Eigen::Index>(i)) = y;
  }
}

SampledSurface sample_surface(const SurfaceBasis& basis, const SurfaceState& state) {
  SampledSurface surface;
  surface.mesh.triangles = basis.sphere.triangles;
  const Eigen::VectorXd radii = basis.values * state.radius;
  surface.mesh.vertices_m.reserve(basis.sphere.vertices_m.size());
  for (std::size_t i = 0; i < basis.sphere.vertices_m.size(); ++i) {
    const double radius = std::max(kLeastRadius, 1 + radii[static_cast<Eigen::Index>(i)]);
    surface.mesh.vertices_m.push_back(state.frame.point_m(basis.sphere.vertices_m[i], radius));
  }
  surface.normals = vertex_normals(surface.mesh);
  return surface;
}

double SurfaceProblem::step(SurfaceState& state, ResidualScale& scale, double match_limit_px,
                            double relaxation) const {
  const SampledSurface surface = sample_surface(basis, state);
  const std::vector<Match> matches = match_views(*this, state, surface, match_limit_px);
  const std::vector<PatchResidual> cloud = patch_residuals(*this, state, surface);
  update_scale(*this, matches, cloud, scale);
  NormalEquations equations = assemble(*this, state, matches, cloud, scale);
  eliminate_shifts(equations);

  const Eigen::Index harmonics = basis.harmonics.count();
  const Eigen::VectorXd solution = solve_on_board(
      equations.h, equations.g, contact_of(*this, state, surface), config.plane_sigma_m);
  const Eigen::LLT<Eigen::MatrixXd> solver(equations.h.selfadjointView<Eigen::Lower>());
  if (solver.info() != Eigen::Success || !solution.allFinite()) return kNaN;
  // The radius changes by a quarter at most: beyond, the matches are others.
  const Eigen::VectorXd changes = basis.values * solution.head(harmonics);
  const double largest = changes.cwiseAbs().maxCoeff();
  const double damping = std::min(relaxation, 0.25 / largest);
  state.radius += damping * solution.head(harmonics);
  state.outline_bias_px = solution[harmonics];
  state.cloud_bias_m = solution[harmonics + 1];
  for (std::size_t v = 0; v < views.size(); ++v) {
    state.view_shifts_px[v] =
        equations.h_view[v].inverse() * (equations.g_view[v] - equations.h_mixed[v] * solution);
  }

  // Expectation-maximisation of the evidence: the mean square of b in units of the prior, with its
  // own uncertainty.
  const Eigen::MatrixXd covariance =
      solver.solve(Eigen::MatrixXd::Identity(harmonics + 2, harmonics + 2));
  double sum = 0, count = 0;
  for (int l = 3; l <= basis.harmonics.degree(); ++l) {
    const double bending = l * (l + 1.0);
    for (Eigen::Index i = l * l; i < (l + 1) * (l + 1); ++i) {
      sum += bending * bending * (state.radius[i] * state.radius[i] + covariance(i, i));
      count += 1;
    }
  }
  if (count > 0) state.roughness = std::clamp(std::sqrt(sum / count), 0.02, 20.0);
  return damping * std::sqrt(changes.squaredNorm() / static_cast<double>(changes.size()));
}

Eigen::MatrixXd SurfaceProblem::information(const SurfaceState& state, const ResidualScale& scale,
                                            double match_limit_px) const {
  const SampledSurface surface = sample_surface(basis, state);
  const std::vector<Match> matches = match_views(*this, state, surface, match_limit_px);
  const std::vector<PatchResidual> cloud = patch_residuals(*this, state, surface);
  NormalEquations equations = assemble(*this, state, matches, cloud, scale);
  eliminate_shifts(equations);
  solve_on_board(equations.h, equations.g, contact_of(*this, state, surface), config.plane_sigma_m);
  return Eigen::MatrixXd(equations.h.selfadjointView<Eigen::Lower>());
}

}  // namespace cousin
