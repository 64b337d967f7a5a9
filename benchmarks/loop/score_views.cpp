#include "benchmarks/loop/score_views.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "benchmarks/loop/board_turn.h"
#include "benchmarks/loop/score_geometry.h"
#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/loop/true_outline.h"
#include "benchmarks/score/surface_distance.h"
#include "benchmarks/score/visible_surface.h"
#include "sim/geometry/measure.h"
#include "sim/geometry/similarity.h"
#include "sim/truth/specimens.h"

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

TrueSurfaces true_surfaces(const Scene& scene) {
  std::vector<Mesh> all, specimens, others;
  TrueSurfaces surfaces;
  for (const Instance& instance : scene.instances) {
    Mesh mesh = mesh_in_world(scene, instance);
    if (mesh.triangles.empty()) continue;
    const bool is_own = is_of_specimen(instance);
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
  bool has_cloud = false, has_mesh = false;
  Points cloud_m;
  Mesh mesh;
  Points on_mesh_m;
};

/// None on a mesh without area.
Points points_on(const Mesh& mesh) {
  const auto has_area = [&](const std::array<std::uint32_t, 3>& t) {
    const Eigen::Vector3d& a = mesh.vertices_m[t[0]];
    return (mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a).norm() > 0;
  };
  return std::any_of(mesh.triangles.begin(), mesh.triangles.end(), has_area)
             ? sample_surface(mesh, kMeshSamples, Rng(2))
             : Points();
}

Measured measured_of(const Estimate& estimate, bool has_cloud,
                     const WorldSimilarity& truth_from_estimate) {
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
  measured.on_mesh_m = points_on(measured.mesh);
  measured.has_cloud = has_cloud;
  measured.has_mesh = !estimate.surfaces.empty();
  return measured;
}

/// Says of points whether they lie around a specimen and are nearer to one than to anything else.
class NearSpecimens {
 public:
  explicit NearSpecimens(const TrueSurfaces& surfaces)
      : boxes_(surfaces.around_specimens), specimens_(surfaces.specimens) {
    if (!surfaces.others.triangles.empty()) others_.emplace(surfaces.others);
  }
  std::vector<std::uint8_t> of(const Points& points_m) const {
    std::vector<std::uint8_t> is_own(points_m.size());
    tbb::parallel_for(std::size_t{0}, points_m.size(), [&](std::size_t i) {
      const Eigen::Vector3d& point = points_m[i];
      const bool is_around =
          std::any_of(boxes_.begin(), boxes_.end(),
                      [&](const Eigen::AlignedBox3d& box) { return box.contains(point); });
      is_own[i] =
          is_around && (!others_ || specimens_.distance_m(point) <= others_->distance_m(point)) ? 1
                                                                                                : 0;
    });
    return is_own;
  }

 private:
  const std::vector<Eigen::AlignedBox3d>& boxes_;
  DistanceTree specimens_;
  std::optional<DistanceTree> others_;
};

/// The part near specimens: of a mesh the triangles whose middles are.
Measured part_near(const Measured& measured, const NearSpecimens& near) {
  Measured part{measured.has_cloud, measured.has_mesh, {}, {}, {}};
  const std::vector<std::uint8_t> is_own = near.of(measured.cloud_m);
  for (std::size_t i = 0; i < is_own.size(); ++i) {
    if (is_own[i] != 0) part.cloud_m.push_back(measured.cloud_m[i]);
  }
  Points middles;
  const Points& vertices = measured.mesh.vertices_m;
  for (const auto& t : measured.mesh.triangles)
    middles.push_back((vertices[t[0]] + vertices[t[1]] + vertices[t[2]]) / 3);
  const std::vector<std::uint8_t> is_kept = near.of(middles);
  part.mesh.vertices_m = vertices;
  for (std::size_t i = 0; i < is_kept.size(); ++i) {
    if (is_kept[i] != 0) part.mesh.triangles.push_back(measured.mesh.triangles[i]);
  }
  part.on_mesh_m = points_on(part.mesh);
  return part;
}

/// Rows of the clouds and meshes against `surface`. @param all  what may hide it
void add_shape_rows(const std::string& prefix, const Measured& measured, const Mesh& surface,
                    int samples, const Mesh& all, const std::vector<SurfaceView>& views,
                    const ScoreRow& base, std::vector<ScoreRow>& rows) {
  const VisibleSamples seen = visible_samples(all, sample_surface(surface, samples, Rng(1)), views);
  const auto count = static_cast<std::int64_t>(seen.seen_m.size());
  rows.push_back(measured_row(base, prefix + "surface.seen", static_cast<double>(count) / samples,
                              "1", samples));
  if (count == 0) return;
  if (measured.has_cloud)
    add_cloud_rows(prefix + "cloud_seen", static_cast<std::int64_t>(measured.cloud_m.size()),
                   score_visible_cloud(measured.cloud_m, surface, seen, kTolerances_m), base, rows);
  if (measured.has_mesh)
    add_cloud_rows(
        prefix + "mesh_seen", static_cast<std::int64_t>(measured.on_mesh_m.size()),
        score_visible_mesh(measured.mesh, measured.on_mesh_m, surface, seen, kTolerances_m), base,
        rows);
}

void add_all_shapes(const SceneTruth& truth, const Measured& measured, const ScoreRow& base,
                    std::vector<ScoreRow>& rows) {
  if (!measured.has_cloud && !measured.has_mesh) return;
  const TrueSurfaces surfaces = true_surfaces(truth.scene);
  if (surfaces.all.triangles.empty()) return;
  const std::vector<SurfaceView> views = surface_views(truth);
  add_shape_rows("", measured, surfaces.all, kSceneSamples, surfaces.all, views, base, rows);
  if (surfaces.specimens.triangles.empty()) return;
  add_shape_rows("specimens.", part_near(measured, NearSpecimens(surfaces)), surfaces.specimens,
                 kSpecimenSamples, surfaces.all, views, base, rows);
}

/// The rows of an estimate that cannot be put beside the truth.
void add_unsolved_shapes(const SceneTruth& truth, const Measured& measured, const ScoreRow& base,
                         std::vector<ScoreRow>& rows) {
  CloudScore none;
  for (double* value : {&none.accuracy_mean_m, &none.bias_m, &none.accuracy_rms_m,
                        &none.accuracy_median_m, &none.completeness_mean_m})
    *value = kNaN;
  for (const double tolerance_m : kTolerances_m) none.at.push_back({tolerance_m, kNaN, kNaN, kNaN});
  ScoreRow unsolved = base;
  unsolved.status = ScoreStatus::not_solved;
  const bool has_specimens = !specimens_of(truth.scene).empty();
  for (const std::string prefix : {"", "specimens."}) {
    if (!prefix.empty() && !has_specimens) continue;
    if (measured.has_cloud) add_cloud_rows(prefix + "cloud_seen", 0, none, unsolved, rows);
    if (measured.has_mesh) add_cloud_rows(prefix + "mesh_seen", 0, none, unsolved, rows);
  }
}

/// Focal lengths in pixels of the true cameras, where photographs were made smaller or larger: by a
/// whole number where rows that filled no pixel may have been left out, else by the widths' ratio.
/// Parts cut out of photographs look like smaller ones.
Poses at_true_size(Poses poses, const SceneTruth& truth) {
  for (FramePose& pose : poses) {
    const int width_px = pose.camera.width_px;
    for (const TrueView& view : truth.views) {
      if (view.frame != pose.frame || width_px <= 0) continue;
      const int by =
          static_cast<int>(std::lround(static_cast<double>(view.camera.width_px) / width_px));
      const bool is_whole = by >= 1 && view.camera.width_px / by == width_px;
      pose.camera.fx_px *= is_whole ? by : static_cast<double>(view.camera.width_px) / width_px;
    }
  }
  return poses;
}

std::vector<Pose> middle_poses(const SceneTruth& truth) {
  std::vector<Pose> poses;
  for (const TrueView& view : truth.views) poses.push_back(middle_pose(view));
  return poses;
}

}  // namespace

std::vector<ScoreRow> score_views(const SceneTruth& truth, const Estimate& as_perceived,
                                  PoseAlignment alignment, bool has_cloud, const ScoreRow& base) {
  const bool is_aligned = alignment == PoseAlignment::similarity;
  const Estimate estimate = is_aligned ? as_perceived : turned_to_truth(as_perceived, truth);
  std::vector<ScoreRow> rows;
  add_pose_rows(truth, at_true_size(estimate.poses, truth), alignment, base, rows);
  WorldSimilarity truth_from_estimate;
  bool has_frame = true;
  if (is_aligned) {
    const Poses poses = in_order_of(truth.views, estimate.poses);
    const SimilarityFit fit = fit_to_truth(poses, middle_poses(truth));
    truth_from_estimate = fit.a_from_b;
    has_frame = fit.ok;
    const auto posed = std::count_if(poses.begin(), poses.end(), [](const FramePose& pose) {
      return pose.status == PoseStatus::ok;
    });
    ScoreRow row = measured_row(base, "alignment.scale", fit.ok ? fit.a_from_b.scale : kNaN, "1",
                                static_cast<std::int64_t>(posed));
    if (!fit.ok) row.status = ScoreStatus::not_solved;
    rows.push_back(std::move(row));
  }
  const Measured measured = measured_of(estimate, has_cloud, truth_from_estimate);
  if (has_frame) {
    add_all_shapes(truth, measured, base, rows);
  } else {
    add_unsolved_shapes(truth, measured, base, rows);
  }
  score_timings(estimate, base, rows);
  return rows;
}

}  // namespace cousin
