#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

#include "calibration/bundle/bundle_problem.h"
#include "calibration/solve/quiet_ceres.h"

namespace cousin {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// One observation over its sigma, under the loss. Blocks: lens, pose, point, and the image's zoom
/// where it is free.
class SeenPoint final : public ceres::CostFunction {
 public:
  SeenPoint(const BundleProblem& problem, const BundleObservation& seen)
      : problem_(problem), seen_(seen) {
    const auto lens =
        static_cast<std::size_t>(problem.lens_of_image[static_cast<std::size_t>(seen.image)]);
    shape_ = &problem.shapes[lens];
    set_num_residuals(2);
    *mutable_parameter_block_sizes() = {lens_parameter_count(*shape_), 6, 3};
    if (problem.config.zoom_share > 0) mutable_parameter_block_sizes()->push_back(1);
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const PosedFrame pose(parameters[1]);
    RowMatrix d_lens(2, lens_parameter_count(*shape_));
    Vector2d d_zoom;
    ObservationValue value;
    const bool zooms = problem_.config.zoom_share > 0;
    if (!observe_zoomed(*shape_, parameters[0], zooms ? *parameters[3] : 1, pose,
                        Eigen::Map<const Vector3d>(parameters[2]), value,
                        jacobians != nullptr ? d_lens.data() : nullptr, &d_zoom))
      return false;
    const Vector2d residual = (value.pixel_px - seen_.pixel_px) / seen_.sigma_px;
    const Softened soft = soften(problem_.config.loss, problem_.config.loss_px, residual);
    Eigen::Map<Vector2d>(residuals, 2) = soft.factor * residual;
    if (jacobians == nullptr) return true;
    const Eigen::Matrix2d w = soft.d / seen_.sigma_px;
    const auto put = [&](int block, const auto& d) {
      if (jacobians[block] != nullptr)
        Eigen::Map<RowMatrix>(jacobians[block], 2, d.cols()).noalias() = w.lazyProduct(d);
    };
    put(0, d_lens);
    put(1, value.d_rig_from_points);
    put(2, value.d_point);
    if (zooms && jacobians[3] != nullptr) Eigen::Map<Vector2d>(jacobians[3]).noalias() = w * d_zoom;
    return true;
  }

 private:
  const BundleProblem& problem_;
  const BundleObservation& seen_;
  const LensShape* shape_ = nullptr;
};

class PointPrior final : public ceres::SizedCostFunction<3, 3> {
 public:
  explicit PointPrior(const KnownPoint& known) : known_(known) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    Eigen::Map<Vector3d>(residuals).noalias() =
        (Eigen::Map<const Vector3d>(parameters[0]) - known_.in_world_m) / known_.sigma_m;
    if (jacobians != nullptr && jacobians[0] != nullptr)
      Eigen::Map<RowMatrix>(jacobians[0], 3, 3) = Eigen::Matrix3d::Identity() / known_.sigma_m;
    return true;
  }

 private:
  KnownPoint known_;
};

class DistancePrior final : public ceres::SizedCostFunction<1, 3, 3> {
 public:
  explicit DistancePrior(const KnownDistance& known) : known_(known) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Vector3d apart =
        Eigen::Map<const Vector3d>(parameters[0]) - Eigen::Map<const Vector3d>(parameters[1]);
    const double length = apart.norm();
    if (!(length > 0)) return false;
    residuals[0] = (length - known_.length_m) / known_.sigma_m;
    if (jacobians == nullptr) return true;
    const Vector3d way = apart / (length * known_.sigma_m);
    if (jacobians[0] != nullptr) Eigen::Map<Vector3d>(jacobians[0]).noalias() = way;
    if (jacobians[1] != nullptr) Eigen::Map<Vector3d>(jacobians[1]).noalias() = -way;
    return true;
  }

 private:
  KnownDistance known_;
};

class LensPrior final : public ceres::CostFunction {
 public:
  LensPrior(const Eigen::VectorXd& mean, const Eigen::VectorXd& sigma)
      : mean_(mean), weight_(sigma.cwiseInverse()) {
    set_num_residuals(static_cast<int>(mean.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(mean.size()));
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Index n = mean_.size();
    Eigen::Map<Eigen::VectorXd>(residuals, n) =
        weight_.cwiseProduct(Eigen::Map<const Eigen::VectorXd>(parameters[0], n) - mean_);
    if (jacobians != nullptr && jacobians[0] != nullptr)
      Eigen::Map<RowMatrix>(jacobians[0], n, n) = weight_.asDiagonal();
    return true;
  }

 private:
  Eigen::VectorXd mean_, weight_;
};

class ZoomPrior final : public ceres::SizedCostFunction<1, 1> {
 public:
  explicit ZoomPrior(double sigma) : sigma_(sigma) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    residuals[0] = (*parameters[0] - 1) / sigma_;
    if (jacobians != nullptr && jacobians[0] != nullptr) *jacobians[0] = 1 / sigma_;
    return true;
  }

 private:
  double sigma_;
};

/// All parameters in one piece, points first: Ceres orders blocks by their addresses.
struct Packed {
  std::vector<double> values;
  std::vector<std::size_t> lens_at;
  std::size_t pose_at = 0, zoom_at = 0;

  explicit Packed(const BundleProblem& problem) {
    for (const Vector3d& point : problem.points)
      values.insert(values.end(), point.data(), point.data() + 3);
    pose_at = values.size();
    for (const Vector6d& pose : problem.poses)
      values.insert(values.end(), pose.data(), pose.data() + 6);
    for (const Eigen::VectorXd& lens : problem.lenses) {
      lens_at.push_back(values.size());
      values.insert(values.end(), lens.data(), lens.data() + lens.size());
    }
    zoom_at = values.size();
    values.insert(values.end(), problem.zoom.begin(), problem.zoom.end());
  }
  double* point(int i) { return values.data() + 3 * static_cast<std::size_t>(i); }
  double* pose(int i) { return values.data() + pose_at + 6 * static_cast<std::size_t>(i); }
  double* lens(std::size_t i) { return values.data() + lens_at[i]; }
  double* zoom(int i) { return values.data() + zoom_at + static_cast<std::size_t>(i); }

  void unpack(BundleProblem& problem) {
    for (std::size_t i = 0; i < problem.points.size(); ++i)
      problem.points[i] = Eigen::Map<Vector3d>(point(static_cast<int>(i)));
    for (std::size_t i = 0; i < problem.poses.size(); ++i)
      problem.poses[i] = Eigen::Map<Vector6d>(pose(static_cast<int>(i)));
    for (std::size_t i = 0; i < problem.lenses.size(); ++i)
      problem.lenses[i] = Eigen::Map<Eigen::VectorXd>(lens(i), problem.lenses[i].size());
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(zoom_at), problem.zoom.size(),
                problem.zoom.begin());
  }
};

void add_lens(const BundleProblem& problem, std::size_t i, double* at, ceres::Problem& to) {
  const auto n = static_cast<int>(problem.lenses[i].size());
  to.AddParameterBlock(at, n);
  std::vector<int> constant;
  for (int k = 0; k < n; ++k) {
    if (!problem.free[i][static_cast<std::size_t>(k)]) constant.push_back(k);
  }
  if (static_cast<int>(constant.size()) == n) {
    to.SetParameterBlockConstant(at);
    return;
  }
  if (!constant.empty()) to.SetManifold(at, new ceres::SubsetManifold(n, constant));
  if (problem.prior_sigma[i].array().isFinite().any())
    to.AddResidualBlock(new LensPrior(problem.prior_mean[i], problem.prior_sigma[i]), nullptr, at);
}

/// @param inner  the points that are solved on their own after each step
ceres::Solver::Options bundle_options(
    const BundleProblem& problem, const std::shared_ptr<ceres::ParameterBlockOrdering>& ordering,
    const std::shared_ptr<ceres::ParameterBlockOrdering>& inner) {
  ceres::Solver::Options options;
  constexpr std::size_t kDenseImages = 120;
  options.linear_solver_type =
      problem.poses.size() > kDenseImages ? ceres::SPARSE_SCHUR : ceres::DENSE_SCHUR;
  options.linear_solver_ordering = ordering;
  // A redescending loss leaves few points of a COLMAP model between sightings that contradict each
  // other: there the cost bends the other way, steps of all parameters at once are many times too
  // short, and cost falls by some 1e-7 a step for hundreds of them. Each point solved on its own
  // after each step [Ruhe & Wedin, SIAM Review 1980] gets to its valley at once.
  options.use_inner_iterations = !inner->group_to_elements().empty();
  options.inner_iteration_ordering = inner;
  options.inner_iteration_tolerance = problem.config.tolerance;
  options.num_threads = 1;  // fixed: the sums' order must not depend on the caller's threads
  // Damping alone makes up for a free frame: with a larger radius than this the normal equations
  // are singular to rounding, and each second step fails.
  options.max_trust_region_radius = 1e10;
  options.max_num_iterations = problem.config.max_iterations;
  options.function_tolerance = problem.config.tolerance;
  options.parameter_tolerance = 1e-15;
  options.gradient_tolerance = 1e-30;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

std::string minimise_bundle(BundleProblem& problem, int& iterations) {
  quiet_warnings();
  Packed packed(problem);
  ceres::Problem to;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  std::set<int> tied;  // points that share a residual cannot be eliminated together
  for (const KnownDistance& known : problem.known_distances)
    tied.insert({known.point_a, known.point_b});
  for (std::size_t i = 0; i < problem.lenses.size(); ++i) {
    add_lens(problem, i, packed.lens(i), to);
    ordering->AddElementToGroup(packed.lens(i), 1);
  }
  std::set<int> seen_points, seen_images;
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    const BundleObservation& seen = problem.observations[i];
    if (!problem.used[i]) continue;
    const int lens = problem.lens_of_image[static_cast<std::size_t>(seen.image)];
    std::vector<double*> blocks = {packed.lens(static_cast<std::size_t>(lens)),
                                   packed.pose(seen.image), packed.point(seen.point)};
    if (problem.config.zoom_share > 0) blocks.push_back(packed.zoom(seen.image));
    to.AddResidualBlock(new SeenPoint(problem, seen), nullptr, blocks);
    ordering->AddElementToGroup(packed.pose(seen.image), 1);
    seen_images.insert(seen.image);
    seen_points.insert(seen.point);
  }
  for (const int image : seen_images) {
    if (!(problem.config.zoom_share > 0)) break;
    to.AddResidualBlock(new ZoomPrior(problem.config.zoom_share), nullptr, packed.zoom(image));
    ordering->AddElementToGroup(packed.zoom(image), 1);
  }
  for (const KnownPoint& known : problem.known_points) {
    to.AddResidualBlock(new PointPrior(known), nullptr, packed.point(known.point));
    seen_points.insert(known.point);
  }
  for (const KnownDistance& known : problem.known_distances) {
    to.AddResidualBlock(new DistancePrior(known), nullptr, packed.point(known.point_a),
                        packed.point(known.point_b));
    seen_points.insert({known.point_a, known.point_b});
  }
  auto inner = std::make_shared<ceres::ParameterBlockOrdering>();
  for (const int point : seen_points) {
    ordering->AddElementToGroup(packed.point(point), tied.contains(point) ? 1 : 0);
    if (!tied.contains(point)) inner->AddElementToGroup(packed.point(point), 0);
  }
  ceres::Solver::Summary summary;
  ceres::Solve(bundle_options(problem, ordering, inner), &to, &summary);
  packed.unpack(problem);
  iterations += static_cast<int>(summary.iterations.size());
  if (summary.termination_type == ceres::CONVERGENCE) return "";
  std::vector<double> costs;
  for (const ceres::IterationSummary& step : summary.iterations) costs.push_back(step.cost);
  if (summary.termination_type == ceres::NO_CONVERGENCE && cost_has_settled(costs)) return "";
  return "Ceres: " + summary.message;
}

}  // namespace cousin
