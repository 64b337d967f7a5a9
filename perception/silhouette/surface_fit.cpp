#include "perception/silhouette/surface_fit.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "perception/silhouette/icosphere.h"
#include "perception/silhouette/surface_problem.h"
#include "sim/config/limits.h"
#include "sim/geometry/measure.h"

namespace cousin {
namespace {

constexpr std::size_t kLeastCloudPoints = 10;
constexpr std::size_t kLeastViews = 3;
constexpr std::size_t kLeastOutlinePoints = 8;
constexpr int kCoarseDegree = 4;
constexpr int kCoarseIterations = 8;
constexpr int kFullSteps = 6;
constexpr double kCoarseLimit_px = 25;  ///< how far an outline may be from the first model
constexpr double kFineLimit_px = 4;
constexpr double kConverged =
    2e-4;  ///< change of the radius, relative, root mean square: 1 um on a seed
constexpr double kLooselyConverged = 4e-3;
constexpr double kLowestPoint_m = 3e-4;  ///< stereo mixes object and board below

std::vector<OutlineView> views_of(int instance, const Poses& poses,
                                  const Silhouettes& silhouettes) {
  std::map<int, const FramePose*> posed;
  for (const FramePose& pose : poses) {
    if (pose.status == PoseStatus::ok) posed[pose.frame] = &pose;
  }
  std::vector<OutlineView> views;
  for (const Silhouette& silhouette : silhouettes) {
    if (silhouette.instance != instance) continue;
    const auto pose = posed.find(silhouette.frame);
    if (pose == posed.end()) continue;
    OutlineView view{*pose->second, {}, {}};
    for (std::size_t i = 0; i < silhouette.outline.size(); ++i) {
      const OutlinePoint& point = silhouette.outline[i];
      const bool usable = point.on_object && point.pixel_px.allFinite() &&
                          point.normal.allFinite() && point.sigma_px > 0 &&
                          std::isfinite(point.sigma_px);
      if (!usable) continue;
      view.points.push_back(point);
      view.positions.push_back(static_cast<int>(i));
    }
    if (view.points.size() >= kLeastOutlinePoints) views.push_back(std::move(view));
  }
  return views;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The cloud in patches about the vertices of a coarse sphere in the frame: stereo errs alike
/// within a patch.
std::vector<CloudPatch> patches_of(const std::vector<Eigen::Vector3d>& points_m,
                                   const SurfaceFrame& frame, const Mesh& coarse, double sigma_m) {
  const Eigen::Matrix3d u_from_world = frame.axes_m.inverse();
  struct Cell {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    std::vector<double> radii;
  };
  std::vector<Cell> cells(coarse.vertices_m.size());
  for (const Eigen::Vector3d& point : points_m) {
    if (point.z() < kLowestPoint_m) continue;
    const Eigen::Vector3d scaled = u_from_world * (point - frame.centre_m);
    if (scaled.norm() < 0.05) continue;
    const Eigen::Vector3d u = scaled.normalized();
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < coarse.vertices_m.size(); ++i) {
      if (coarse.vertices_m[i].dot(u) > coarse.vertices_m[nearest].dot(u)) nearest = i;
    }
    cells[nearest].sum += u;
    cells[nearest].radii.push_back(scaled.norm());
  }
  std::vector<CloudPatch> patches;
  for (const Cell& cell : cells) {
    if (cell.radii.size() < 3) continue;
    patches.push_back({frame.point_m(cell.sum.normalized(), median(cell.radii)), sigma_m});
  }
  return patches;
}

/// Points in the upper half of a model, at least `rim_m` inside its footprint.
std::vector<Eigen::Vector3d> well_inside(const std::vector<Eigen::Vector3d>& points_m,
                                         const Mesh& model, double rim_m) {
  const auto from_above = [](const Eigen::Vector3d& p) {
    return cv::Point2f(static_cast<float>(p.x()), static_cast<float>(p.y()));
  };
  std::vector<cv::Point2f> vertices, footprint;
  double top_m = 0;
  for (const Eigen::Vector3d& vertex : model.vertices_m) {
    vertices.push_back(from_above(vertex));
    top_m = std::max(top_m, vertex.z());
  }
  cv::convexHull(vertices, footprint);
  std::vector<Eigen::Vector3d> kept;
  for (const Eigen::Vector3d& point : points_m) {
    if (point.z() <= 0.5 * top_m) continue;
    if (cv::pointPolygonTest(footprint, from_above(point), true) >= rim_m) kept.push_back(point);
  }
  return kept;
}

/// What all objects share.
struct FitTables {
  SurfaceBasis coarse, fine;
  Mesh patch_sphere = icosphere(3);
  Mesh final_sphere;
  explicit FitTables(const SurfaceFitConfig& config)
      : coarse(std::min(kCoarseDegree, config.degree), 3),
        fine(config.degree, 4),
        final_sphere(icosphere(config.subdivisions)) {}
};

Eigen::MatrixXd basis_at(const Mesh& sphere, const RealHarmonics& harmonics) {
  Eigen::MatrixXd values(harmonics.count(), static_cast<Eigen::Index>(sphere.vertices_m.size()));
  for (std::size_t i = 0; i < sphere.vertices_m.size(); ++i) {
    harmonics.evaluate(sphere.vertices_m[i], values.col(static_cast<Eigen::Index>(i)));
  }
  return values;
}

std::vector<Eigen::Vector3d> vertices_of(const Mesh& sphere, const SurfaceFrame& frame,
                                         const Eigen::VectorXd& radii) {
  std::vector<Eigen::Vector3d> vertices;
  vertices.reserve(sphere.vertices_m.size());
  for (std::size_t i = 0; i < sphere.vertices_m.size(); ++i) {
    vertices.push_back(
        frame.point_m(sphere.vertices_m[i], 1 + radii[static_cast<Eigen::Index>(i)]));
  }
  return vertices;
}

/// Mesh and samples of a converged state.
void fill_surface(const SurfaceProblem& problem, const SurfaceState& state,
                  const ResidualScale& scale, const Mesh& sphere, Rng rng, Surface& surface) {
  const Eigen::Index harmonics = problem.basis.harmonics.count();
  const Eigen::MatrixXd values = basis_at(sphere, problem.basis.harmonics);
  surface.mesh.triangles = sphere.triangles;
  surface.mesh.vertices_m = vertices_of(sphere, state.frame, values.transpose() * state.radius);
  // H = L L^T: L^-T z has the covariance H^-1.
  const Eigen::LLT<Eigen::MatrixXd> root(problem.information(state, scale, kFineLimit_px));
  if (root.info() != Eigen::Success) return;  // no samples: sigmas are not known
  for (int s = 0; s < problem.config.samples; ++s) {
    Rng draw = rng.fork(static_cast<std::uint64_t>(s));
    Eigen::VectorXd z(harmonics + 2);
    for (Eigen::Index i = 0; i < z.size(); ++i) z[i] = normal(draw);
    const Eigen::VectorXd change = root.matrixU().solve(z);
    surface.samples_m.push_back(vertices_of(
        sphere, state.frame, values.transpose() * (state.radius + change.head(harmonics))));
  }
}

double solidity(const Mesh& mesh) {
  const Mesh hull = convex_hull(mesh.vertices_m);
  if (hull.triangles.empty()) return 1;
  return mass_properties(mesh).volume_m3 / mass_properties(hull).volume_m3;
}

SurfaceState sphere_in(const SurfaceFrame& frame, const SurfaceProblem& problem) {
  SurfaceState state;
  state.frame = frame;
  state.radius = Eigen::VectorXd::Zero(problem.basis.harmonics.count());
  state.view_shifts_px.assign(problem.views.size(), Eigen::Vector2d::Zero());
  return state;
}

/// @returns false where the fit is lost
bool fit_coarse(const SurfaceProblem& coarse, SurfaceState& state, ResidualScale& scale) {
  for (int i = 0; i < kCoarseIterations; ++i) {
    const double change = coarse.step(state, scale, kCoarseLimit_px);
    if (!std::isfinite(change)) return false;
    if (change < 0.01) break;
  }
  return true;
}

/// @returns the last change of the radius; not finite where the fit is lost
double fit_fine(const SurfaceProblem& fine, SurfaceState& state, ResidualScale& scale) {
  double change = 1;
  for (int i = 0; i < fine.config.max_iterations && change > kConverged; ++i) {
    // Matches and weights change with the surface: late steps are shortened, or they would go to
    // and fro.
    const double relaxation = i < kFullSteps ? 1 : 0.6;
    change = fine.step(state, scale, i < 3 ? kCoarseLimit_px : kFineLimit_px, relaxation);
    if (!std::isfinite(change)) break;
  }
  return change;
}

/// @param change  the fine fit's last, of the radius
SurfaceStatus status_of_fit(const SurfaceProblem& fine, const SurfaceState& state,
                            const ResidualScale& scale, double change) {
  const SurfaceFitConfig& config = fine.config;
  if ((fine.basis.values * state.radius).minCoeff() < -0.8) return SurfaceStatus::not_converged;
  const bool poor = change > kLooselyConverged ||
                    (config.use_outlines && (scale.matched < 0.7 || scale.inliers < 0.7));
  // Far from convex says more than that the fit is poor, if it has a hold of the outlines at all.
  const bool astray = change > 0.2 || (config.use_outlines && scale.matched < 0.4);
  const bool touching = solidity(sample_surface(fine.basis, state).mesh) < config.min_solidity;
  if (poor && (astray || !touching)) return SurfaceStatus::not_converged;
  return touching ? SurfaceStatus::touching : SurfaceStatus::ok;
}

Surface fit_one(int instance, const Poses& poses, std::vector<Eigen::Vector3d> points_m,
                const Silhouettes& silhouettes, const SurfaceFitConfig& config,
                const FitTables& tables, Rng rng) {
  Surface surface;
  surface.instance = instance;
  surface.points_m = std::move(points_m);
  if (surface.points_m.size() < kLeastCloudPoints) {
    surface.status = SurfaceStatus::empty;
    return surface;
  }
  std::vector<OutlineView> views;
  if (config.use_outlines) {
    views = views_of(instance, poses, silhouettes);
    if (views.size() < kLeastViews) {
      surface.status = SurfaceStatus::too_few_views;
      return surface;
    }
  }
  surface.status = SurfaceStatus::not_converged;
  const auto patches = [&](const SurfaceFrame& frame, const std::vector<Eigen::Vector3d>& from) {
    return patches_of(from, frame, tables.patch_sphere, config.cloud_sigma_m);
  };

  // Coarse shape from the cloud's box; it gives the frame of the fine one.
  const SurfaceFrame first = frame_of_points(surface.points_m);
  const std::vector<CloudPatch> first_cloud =
      config.use_outlines ? std::vector<CloudPatch>{} : patches(first, surface.points_m);
  SurfaceProblem coarse{tables.coarse, config, views, first_cloud};
  SurfaceState state = sphere_in(first, coarse);
  ResidualScale scale;
  if (!fit_coarse(coarse, state, scale)) return surface;
  const Mesh model = sample_surface(tables.coarse, state).mesh;
  const SurfaceFrame frame = frame_of_solid(model);
  if (!frame.centre_m.allFinite() || !frame.axes_m.allFinite()) return surface;

  std::vector<CloudPatch> cloud;
  if (!config.use_outlines) {
    cloud = patches(frame, surface.points_m);
  } else if (config.use_cloud) {
    cloud = patches(frame, well_inside(surface.points_m, model, config.cloud_rim_m));
  }
  SurfaceProblem fine{tables.fine, config, std::move(coarse.views), std::move(cloud)};
  state = sphere_in(frame, fine);
  const double change = fit_fine(fine, state, scale);
  if (!std::isfinite(change)) return surface;
  surface.status = status_of_fit(fine, state, scale, change);
  if (surface.status != SurfaceStatus::not_converged)
    fill_surface(fine, state, scale, tables.final_sphere, rng, surface);
  return surface;
}

}  // namespace

Fields fields(SurfaceFitConfig& config) {
  return {
      {"degree", &config.degree, "of the spherical harmonics of the radius", 2, 32},
      {"smoothness", &config.smoothness, "weight of the prior on bending", 1e-6, 1e6},
      {"subdivisions", &config.subdivisions, "of the icosahedron for the final mesh", 2, 7},
      {"max_iterations", &config.max_iterations, "of the fine fit", 1, 1000},
      {"samples", &config.samples, "surfaces drawn from the fit's uncertainty", 0, 10000},
      {"use_cloud", &config.use_cloud, "fit the multi-view stereo points too"},
      {"use_outlines", &config.use_outlines, "fit the outlines"},
      {"plane_sigma_m", &config.plane_sigma_m, "of the contact with the board", 1e-7, 1e-2},
      {"cloud_sigma_m", &config.cloud_sigma_m, "of the cloud's mean in a patch", 1e-7, 1e-2},
      {"cloud_bias_sigma_m", &config.cloud_bias_sigma_m, "of an offset of the whole cloud", 1e-9,
       1e-2},
      {"cloud_rim_m", &config.cloud_rim_m,
       "cloud points nearer to the footprint's edge are left out", 0, 1},
      {"outline_bias_sigma_px", &config.outline_bias_sigma_px, "of an offset of all outlines", 1e-6,
       10},
      {"view_shift_sigma_px", &config.view_shift_sigma_px, "of a view's shift in the image", 1e-6,
       10},
      {"contact_sigma_px", &config.contact_sigma_px, "of outlines at the board, beside their own",
       0, 10},
      {"contact_height_px", &config.contact_height_px,
       "height over which that falls by a factor e, in pixels as they span it there", 1e-3, 1e3},
      {"min_solidity", &config.min_solidity, "least volume over the convex hull's", 0, 1},
  };
}

void validate(const SurfaceFitConfig& config) {
  SurfaceFitConfig copy = config;
  check_limits(fields(copy));
  if (!config.use_cloud && !config.use_outlines) {
    throw std::invalid_argument("use_cloud and use_outlines are both false: nothing to fit");
  }
}

Surfaces fit_surfaces(const Poses& poses, const Clusters& clusters, const Silhouettes& silhouettes,
                      const SurfaceFitConfig& config, Rng rng) {
  validate(config);
  if (clusters.instance.size() != clusters.cloud.size()) {
    throw std::invalid_argument("clusters: " + std::to_string(clusters.instance.size()) +
                                " instances for " + std::to_string(clusters.cloud.size()) +
                                " points");
  }
  std::vector<std::vector<Eigen::Vector3d>> points(
      static_cast<std::size_t>(std::max(0, clusters.count)));
  for (std::size_t i = 0; i < clusters.cloud.size(); ++i) {
    const int instance = clusters.instance[i];
    if (instance < 0 || instance >= clusters.count || !clusters.cloud[i].position_m.allFinite())
      continue;
    points[static_cast<std::size_t>(instance)].push_back(
        clusters.cloud[i].position_m.cast<double>());
  }
  const FitTables tables(config);
  Surfaces surfaces(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    surfaces[i] = fit_one(static_cast<int>(i), poses, std::move(points[i]), silhouettes, config,
                          tables, rng.fork(i));
  });
  return surfaces;
}

}  // namespace cousin
