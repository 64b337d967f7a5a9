#include "benchmarks/views/score_views.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "benchmarks/metrics/surface_distance.h"
#include "benchmarks/metrics/visible_surface.h"
#include "benchmarks/seeds/board_turn.h"
#include "benchmarks/seeds/score_geometry.h"
#include "benchmarks/seeds/score_seeds.h"
#include "benchmarks/seeds/true_outline.h"
#include "sim/geometry/measure.h"
#include "sim/geometry/similarity.h"

namespace cousin {
namespace {

using Points = std::vector<Eigen::Vector3d>;

constexpr std::array<double, 3> kTolerances_m = {0.0002, 0.001, 0.005};
// Of all surfaces, most of which may be the bench's, and of the specimens'.
constexpr int kSceneSamples = 60000;
constexpr int kSpecimenSamples = 20000;
constexpr int kMeshSamples = 60000;

struct TrueSurfaces {
  Mesh all, specimens, others;
  /// Of each specimen and organ, grown on every side by half its diagonal.
  std::vector<Eigen::AlignedBox3d> around_specimens;
};

Eigen::AlignedBox3d around(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) box.extend(vertex);
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(0.5 * box.diagonal().norm());
  return {box.min() - margin, box.max() + margin};
}

bool is_of_specimen(const Scene& scene, const Instance& instance) {
  if (instance.part_of < 0) return instance.is_specimen;
  return std::any_of(scene.instances.begin(), scene.instances.end(), [&](const Instance& whole) {
    return whole.id == instance.part_of && whole.is_specimen;
  });
}

TrueSurfaces true_surfaces(const Scene& scene) {
  std::vector<Mesh> all, specimens, others;
  TrueSurfaces surfaces;
  for (const Instance& instance : scene.instances) {
    Mesh mesh = mesh_in_world(scene, instance);
    if (mesh.triangles.empty()) continue;
    const bool is_own = is_of_specimen(scene, instance);
    if (is_own) surfaces.around_specimens.push_back(around(mesh));
    (is_own ? specimens : others).push_back(mesh);
    all.push_back(std::move(mesh));
  }
  surfaces.all = merged(all);
  surfaces.specimens = merged(specimens);
  surfaces.others = merged(others);
  return surfaces;
}

/// What the estimate holds of surfaces.
struct Measured {
  Points cloud_m;
  Mesh mesh;
  Points on_mesh_m;
};

Measured measured_of(const SeedsEstimate& estimate, const WorldSimilarity& truth_from_estimate) {
  Measured measured;
  for (const CloudPoint& point : estimate.cloud)
    measured.cloud_m.push_back(truth_from_estimate * point.position_m.cast<double>());
  std::vector<Mesh> meshes;
  for (const Surface& surface : estimate.surfaces) {
    if (surface.status != SurfaceStatus::ok || surface.mesh.triangles.empty()) continue;
    meshes.push_back(surface.mesh);
    for (Eigen::Vector3d& vertex : meshes.back().vertices_m) vertex = truth_from_estimate * vertex;
  }
  measured.mesh = merged(meshes);
  if (!measured.mesh.triangles.empty())
    measured.on_mesh_m = sample_surface(measured.mesh, kMeshSamples, Rng(2));
  return measured;
}

/// Those that lie around a specimen and are nearer to one than to anything else.
Points near_specimens(const Points& points_m, const TrueSurfaces& surfaces,
                      const DistanceTree& specimens, const DistanceTree& others) {
  std::vector<std::uint8_t> is_own(points_m.size());
  tbb::parallel_for(std::size_t{0}, points_m.size(), [&](std::size_t i) {
    const bool is_around =
        std::any_of(surfaces.around_specimens.begin(), surfaces.around_specimens.end(),
                    [&](const Eigen::AlignedBox3d& box) { return box.contains(points_m[i]); });
    is_own[i] =
        is_around && specimens.distance_m(points_m[i]) <= others.distance_m(points_m[i]) ? 1 : 0;
  });
  Points result;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    if (is_own[i] != 0) result.push_back(points_m[i]);
  }
  return result;
}

/// Rows of the clouds and meshes against `surface`. @param all  what may hide it
void add_shape_rows(const std::string& prefix, const Measured& measured, const Mesh& surface,
                    int samples, const Mesh& all, const std::vector<SurfaceView>& views,
                    const ScoreRow& base, std::vector<ScoreRow>& rows) {
  const VisibleSamples seen =
      visible_samples(all, sample_surface(surface, samples, Rng(1)), views);
  const auto count = static_cast<std::int64_t>(seen.seen_m.size());
  rows.push_back(measured_row(base, prefix + "surface.seen",
                              static_cast<double>(count) / samples, "1", samples));
  if (count == 0) return;
  if (!measured.cloud_m.empty())
    add_cloud_rows(prefix + "cloud_seen", static_cast<std::int64_t>(measured.cloud_m.size()),
                   score_visible_cloud(measured.cloud_m, surface, seen, kTolerances_m), base, rows);
  if (!measured.on_mesh_m.empty())
    add_cloud_rows(
        prefix + "mesh_seen", static_cast<std::int64_t>(measured.on_mesh_m.size()),
        score_visible_mesh(measured.mesh, measured.on_mesh_m, surface, seen, kTolerances_m), base,
        rows);
}

void add_all_shapes(const SceneTruth& truth, const Measured& measured, const ScoreRow& base,
                    std::vector<ScoreRow>& rows) {
  if (measured.cloud_m.empty() && measured.on_mesh_m.empty()) return;
  const TrueSurfaces surfaces = true_surfaces(truth.scene);
  if (surfaces.all.triangles.empty()) return;
  const std::vector<SurfaceView> views = surface_views(truth);
  add_shape_rows("", measured, surfaces.all, kSceneSamples, surfaces.all, views, base, rows);
  if (surfaces.specimens.triangles.empty() || surfaces.others.triangles.empty()) return;
  const DistanceTree specimens(surfaces.specimens), others(surfaces.others);
  Measured own;
  own.cloud_m = near_specimens(measured.cloud_m, surfaces, specimens, others);
  own.mesh = measured.mesh;
  own.on_mesh_m = near_specimens(measured.on_mesh_m, surfaces, specimens, others);
  add_shape_rows("specimens.", own, surfaces.specimens, kSpecimenSamples, surfaces.all, views, base,
                 rows);
}

/// Focal lengths in pixels of the true cameras, where photographs were made smaller by a whole
/// number.
Poses at_true_size(Poses poses, const SceneTruth& truth) {
  for (FramePose& pose : poses) {
    for (const TrueView& view : truth.views) {
      if (view.frame != pose.frame || pose.camera.width_px <= 0) continue;
      const double by = std::round(static_cast<double>(view.camera.width_px) / pose.camera.width_px);
      if (by > 1) pose.camera.fx_px *= by;
    }
  }
  return poses;
}

SimilarityFit fit_to_truth(const SceneTruth& truth, const Poses& estimate) {
  const Poses poses = in_order_of(truth.views, estimate);
  Points true_m, own_m;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i].status != PoseStatus::ok) continue;
    true_m.push_back(centre_in_world_m(middle_pose(truth.views[i])));
    own_m.push_back(centre_in_world_m(poses[i].camera_from_world));
  }
  return fit_similarity(true_m, own_m);
}

}  // namespace

std::vector<ScoreRow> score_views(const SceneTruth& truth, const SeedsEstimate& as_perceived,
                                  PoseAlignment alignment, const ScoreRow& base) {
  const bool is_aligned = alignment == PoseAlignment::similarity;
  const SeedsEstimate estimate = is_aligned ? as_perceived : turned_to_truth(as_perceived, truth);
  std::vector<ScoreRow> rows;
  add_pose_rows(truth, at_true_size(estimate.poses, truth), alignment, base, rows);
  WorldSimilarity truth_from_estimate;
  bool has_frame = true;
  if (is_aligned) {
    const SimilarityFit fit = fit_to_truth(truth, estimate.poses);
    truth_from_estimate = fit.a_from_b;
    has_frame = fit.ok;
    ScoreRow row = measured_row(base, "alignment.scale", fit.ok ? fit.a_from_b.scale : kNaN, "1",
                                static_cast<std::int64_t>(estimate.poses.size()));
    if (!fit.ok) row.status = ScoreStatus::not_solved;
    rows.push_back(std::move(row));
  }
  if (has_frame) add_all_shapes(truth, measured_of(estimate, truth_from_estimate), base, rows);
  score_timings(estimate, base, rows);
  return rows;
}

}  // namespace cousin
