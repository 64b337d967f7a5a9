#include "benchmarks/loop/board_turn.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <map>
#include <numbers>

#include "benchmarks/loop/true_outline.h"
#include "sim/geometry/measure.h"
#include "sim/truth/specimens.h"

namespace cousin {
namespace {

Eigen::Quaterniond quarter_turns(int count) {
  return Eigen::Quaterniond(
      Eigen::AngleAxisd(0.5 * std::numbers::pi * count, Eigen::Vector3d::UnitZ()));
}

/// Sum of the distances from the turned cameras to the true ones; NaN without a posed view.
double camera_distance(const Estimate& estimate, const SceneTruth& truth,
                       const Eigen::Quaterniond& turn) {
  std::map<int, Eigen::Vector3d> true_centres;
  for (const TrueView& view : truth.views) {
    true_centres[view.frame] = centre_in_world_m(middle_pose(view));
  }
  double sum = 0;
  int posed = 0;
  for (const FramePose& pose : estimate.poses) {
    const auto found = true_centres.find(pose.frame);
    if (pose.status != PoseStatus::ok || found == true_centres.end()) continue;
    sum += (turn * centre_in_world_m(pose.camera_from_world) - found->second).norm();
    ++posed;
  }
  return posed > 0 ? sum : kNaN;
}

/// Sum of the distances from the turned centroids to the nearest true specimen.
double specimen_distance(const Estimate& estimate, const SceneTruth& truth,
                         const Eigen::Quaterniond& turn) {
  std::vector<Eigen::Vector3d> centroids;
  for (const Instance* object : specimens_of(truth.scene)) {
    centroids.push_back(mass_properties(mesh_in_world(truth.scene, *object)).centroid_m);
  }
  double sum = 0;
  for (const SpecimenTraits& specimen : estimate.traits) {
    if (!specimen.centroid_in_world_m.allFinite()) continue;
    double nearest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& centroid : centroids) {
      nearest = std::min(nearest, (turn * specimen.centroid_in_world_m - centroid).norm());
    }
    sum += nearest;
  }
  return sum;
}

void turn_cloud(Cloud& cloud, const Eigen::Quaternionf& turn) {
  for (CloudPoint& point : cloud) {
    point.position_m = turn * point.position_m;
    point.normal = turn * point.normal;
  }
}

void turn_points(std::vector<Eigen::Vector3d>& points, const Eigen::Quaterniond& turn) {
  for (Eigen::Vector3d& point : points) point = turn * point;
}

}  // namespace

Estimate turned_to_truth(const Estimate& estimate, const SceneTruth& truth) {
  if (truth.scene.board != "plain") return estimate;
  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int count = 0; count < 4; ++count) {
    double distance = camera_distance(estimate, truth, quarter_turns(count));
    if (distance != distance) distance = specimen_distance(estimate, truth, quarter_turns(count));
    if (distance < least) least = distance, best = count;
  }
  if (best == 0) return estimate;
  const Eigen::Quaterniond turn = quarter_turns(best);
  Estimate turned = estimate;
  for (FramePose& pose : turned.poses) {
    pose.camera_from_world = pose.camera_from_world * inverse(Pose{turn, Eigen::Vector3d::Zero()});
  }
  turn_cloud(turned.cloud, turn.cast<float>());
  turn_cloud(turned.clusters.cloud, turn.cast<float>());
  for (Surface& surface : turned.surfaces) {
    turn_points(surface.mesh.vertices_m, turn);
    turn_points(surface.points_m, turn);
    for (std::vector<Eigen::Vector3d>& sample : surface.samples_m) turn_points(sample, turn);
  }
  for (SpecimenTraits& specimen : turned.traits) {
    specimen.centroid_in_world_m = turn * specimen.centroid_in_world_m;
  }
  return turned;
}

}  // namespace cousin
