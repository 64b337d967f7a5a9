#include "benchmarks/loop/score_geometry.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

#include "benchmarks/loop/true_outline.h"

namespace cousin {

ScoreRow measured_row(ScoreRow row, const std::string& metric, double value,
                      const std::string& unit, std::int64_t n) {
  row.metric = metric;
  row.value = value;
  row.unit = unit;
  row.n = n;
  return row;
}

std::vector<SurfaceView> surface_views(const SceneTruth& truth) {
  std::vector<SurfaceView> views;
  for (const TrueView& view : truth.views) views.push_back({view.camera, middle_pose(view)});
  return views;
}

Poses in_order_of(const std::vector<TrueView>& views, const Poses& poses) {
  std::map<int, std::size_t> place;
  Poses result;
  for (const TrueView& view : views) {
    place[view.frame] = result.size();
    result.push_back({.frame = view.frame, .status = PoseStatus::no_board});
  }
  std::set<int> found;
  for (const FramePose& pose : poses) {
    const auto at = place.find(pose.frame);
    if (at == place.end() || !found.insert(pose.frame).second)
      throw std::invalid_argument(
          "poses: frame " + std::to_string(pose.frame) +
          (at == place.end() ? " is none of the truth's" : " occurs twice"));
    result[at->second] = pose;
  }
  return result;
}

void add_pose_rows(const SceneTruth& truth, const Poses& poses, PoseAlignment alignment,
                   const ScoreRow& base, std::vector<ScoreRow>& rows) {
  if (poses.empty() || truth.views.empty()) return;
  std::vector<Pose> true_poses;
  std::vector<Camera> cameras;
  for (const SurfaceView& view : surface_views(truth)) {
    true_poses.push_back(view.camera_from_world);
    cameras.push_back(view.camera);
  }
  const PoseScore score =
      score_poses(in_order_of(truth.views, poses), true_poses, cameras, alignment);
  ScoreRow row = base;
  const auto add = [&](const std::string& metric, double value, const char* unit, std::int64_t n) {
    rows.push_back(measured_row(row, metric, value, unit, n));
  };
  add("views.posed", static_cast<double>(score.posed) / std::max(1, score.views), "1", score.views);
  add("camera.focal_rms", score.focal_rms, "1", score.posed);
  if (std::isnan(score.scale)) row.status = ScoreStatus::not_solved;
  add("camera.centre_rms", score.centre_rms_m, "m", score.posed);
  add("camera.centre_max", score.centre_max_m, "m", score.posed);
  add("camera.rotation_rms", score.rotation_rms_rad, "rad", score.posed);
}

void add_cloud_rows(const std::string& what, std::int64_t points, const CloudScore& score,
                    const ScoreRow& base, std::vector<ScoreRow>& rows) {
  const auto add = [&](const std::string& metric, double value, const char* unit, std::int64_t n) {
    rows.push_back(measured_row(base, what + metric, value, unit, n));
  };
  const std::int64_t measured = score.measured_points, samples = score.surface_samples;
  add(".points", static_cast<double>(points), "1", 1);
  add(".accuracy_rms", score.accuracy_rms_m, "m", measured);
  add(".accuracy_mean", score.accuracy_mean_m, "m", measured);
  add(".accuracy_median", score.accuracy_median_m, "m", measured);
  add(".bias", score.bias_m, "m", measured);
  add(".completeness_mean", score.completeness_mean_m, "m", samples);
  add(".chamfer", chamfer_m(score), "m", measured + samples);
  for (const CloudScore::AtTolerance& at : score.at) {
    const std::string tolerance = std::to_string(std::lround(at.tolerance_m * 1e6)) + "um";
    add(".precision_" + tolerance, at.precision, "1", measured);
    add(".recall_" + tolerance, at.recall, "1", samples);
    add(".f1_" + tolerance, at.f1, "1", measured + samples);
  }
}

}  // namespace cousin
