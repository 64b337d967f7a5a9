#include "benchmarks/score/image_scores.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "benchmarks/score/order_statistics.h"

namespace cousin {
namespace {

template <class A, class B>
void require_same_size(const Image<A>& a, const Image<B>& b, const char* what) {
  if (a.width() == b.width() && a.height() == b.height()) return;
  throw std::invalid_argument(std::string(what) + ": " + std::to_string(a.width()) + " x " +
                              std::to_string(a.height()) + " against " + std::to_string(b.width()) +
                              " x " + std::to_string(b.height()));
}

/// Mean distance of cameras from the point nearest to their optical axes; NaN if these are
/// parallel.
double looking_distance_m(std::span<const Pose> camera_from_world) {
  Eigen::Matrix3d across = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Pose& pose : camera_from_world) {
    const Eigen::Vector3d axis = pose.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Matrix3d off_axis = Eigen::Matrix3d::Identity() - axis * axis.transpose();
    across += off_axis;
    sum += off_axis * centre_in_world_m(pose);
  }
  const Eigen::FullPivLU<Eigen::Matrix3d> solver(across);
  constexpr double kLeastPivot = 1e-9;  // of the number of cameras
  const double least = solver.matrixLU().diagonal().cwiseAbs().minCoeff();
  if (!(least > kLeastPivot * static_cast<double>(camera_from_world.size()))) return kNaN;
  const Eigen::Vector3d point = solver.solve(sum);
  double distance = 0;
  for (const Pose& pose : camera_from_world) distance += (centre_in_world_m(pose) - point).norm();
  return distance / static_cast<double>(camera_from_world.size());
}

}  // namespace

double mask_iou(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b) {
  require_same_size(a, b, "mask_iou");
  long long both = 0;
  long long either = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const bool in_a = a.data()[i] != 0;
    const bool in_b = b.data()[i] != 0;
    both += in_a && in_b ? 1 : 0;
    either += in_a || in_b ? 1 : 0;
  }
  return static_cast<double>(both) / static_cast<double>(either);
}

DepthScore score_depth(const Image<float>& estimate_m, const Image<float>& truth_m, double bad_m,
                       const Image<std::uint8_t>& mask) {
  require_same_size(estimate_m, truth_m, "score_depth");
  if (!mask.empty()) require_same_size(mask, truth_m, "score_depth, mask");
  DepthScore score;
  std::vector<double> errors;
  for (std::size_t i = 0; i < truth_m.size(); ++i) {
    const double truth = truth_m.data()[i];
    if (!std::isfinite(truth) || (!mask.empty() && mask.data()[i] == 0)) continue;
    ++score.truth_pixels;
    const double error = estimate_m.data()[i] - truth;
    if (std::isfinite(error)) errors.push_back(error);
  }
  if (score.truth_pixels > 0) {
    score.filled = static_cast<double>(errors.size()) / static_cast<double>(score.truth_pixels);
  }
  score.bias_m = mean(errors);
  score.rmse_m = rms(errors);
  for (double& error : errors) error = std::abs(error);
  score.median_abs_m = quantile(errors, 0.5);
  score.p95_abs_m = quantile(errors, 0.95);
  if (!errors.empty()) {
    const auto bad =
        std::count_if(errors.begin(), errors.end(), [&](double e) { return e > bad_m; });
    score.bad_share = static_cast<double>(bad) / static_cast<double>(errors.size());
  }
  return score;
}

SimilarityFit fit_to_truth(const Poses& estimate, std::span<const Pose> truth_camera_from_world) {
  if (estimate.size() != truth_camera_from_world.size())
    throw std::invalid_argument("fit_to_truth: " + std::to_string(estimate.size()) +
                                " estimates, " + std::to_string(truth_camera_from_world.size()) +
                                " true poses");
  std::vector<Eigen::Vector3d> estimated_m, true_m;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    if (estimate[i].status != PoseStatus::ok) continue;
    estimated_m.push_back(centre_in_world_m(estimate[i].camera_from_world));
    true_m.push_back(centre_in_world_m(truth_camera_from_world[i]));
  }
  return fit_similarity(true_m, estimated_m);
}

PoseScore score_poses(const Poses& estimate, std::span<const Pose> truth_camera_from_world,
                      std::span<const Camera> truth_cameras, PoseAlignment alignment) {
  if (estimate.size() != truth_camera_from_world.size() ||
      (!truth_cameras.empty() && truth_cameras.size() != estimate.size())) {
    throw std::invalid_argument("score_poses: " + std::to_string(estimate.size()) + " estimates, " +
                                std::to_string(truth_camera_from_world.size()) + " true poses, " +
                                std::to_string(truth_cameras.size()) + " true cameras");
  }
  PoseScore score;
  score.views = static_cast<int>(estimate.size());
  std::vector<double> focals;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    if (estimate[i].status != PoseStatus::ok) continue;
    ++score.posed;
    if (!truth_cameras.empty())
      focals.push_back(estimate[i].camera.fx_px / truth_cameras[i].fx_px - 1);
  }
  score.focal_rms = rms(focals);
  WorldSimilarity truth_from_estimate;
  if (alignment == PoseAlignment::similarity) {
    const SimilarityFit fit = fit_to_truth(estimate, truth_camera_from_world);
    score.scale = fit.ok ? fit.a_from_b.scale : kNaN;
    if (!fit.ok) return score;
    truth_from_estimate = fit.a_from_b;
  }
  std::vector<double> centres, rotations;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    if (estimate[i].status != PoseStatus::ok) continue;
    const Pose& truth = truth_camera_from_world[i];
    const Pose own = alignment == PoseAlignment::none
                         ? estimate[i].camera_from_world
                         : moved(estimate[i].camera_from_world, truth_from_estimate);
    centres.push_back((centre_in_world_m(own) - centre_in_world_m(truth)).norm());
    rotations.push_back(angle_rad(own.rotation * truth.rotation.conjugate()));
  }
  score.centre_rms_m = rms(centres);
  score.centre_max_m = quantile(centres, 1);
  score.centre_rms_share = score.centre_rms_m / looking_distance_m(truth_camera_from_world);
  score.rotation_rms_rad = rms(rotations);
  score.rotation_max_rad = quantile(rotations, 1);
  return score;
}

}  // namespace cousin
