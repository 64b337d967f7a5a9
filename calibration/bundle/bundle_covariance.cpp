#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <map>
#include <utility>

#include "calibration/boards/planar_pose.h"
#include "calibration/bundle/bundle_problem.h"

namespace cousin {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

/// Where each free parameter of lenses and poses stands in the reduced system.
struct Places {
  std::vector<std::vector<int>> lens;  ///< of each parameter; -1 = fixed
  int lens_count = 0, count = 0, zoom_at = -1;

  explicit Places(const BundleProblem& problem) {
    for (const std::vector<bool>& free : problem.free) {
      std::vector<int>& own = lens.emplace_back();
      for (const bool is_free : free) own.push_back(is_free ? lens_count++ : -1);
    }
    count = lens_count + 6 * static_cast<int>(problem.poses.size());
    if (!(problem.config.zoom_share > 0)) return;
    zoom_at = count;
    count += static_cast<int>(problem.poses.size());
  }
  int pose(int image) const { return lens_count + 6 * image; }
};

/// An observation's derivatives, weighed: by the free parameters of its lens, its image's zoom and
/// its pose's increments, as columns of the reduced system, and by its point.
struct Row {
  std::vector<int> at;
  MatrixXd d;  ///< 2 x at.size()
  Eigen::Matrix<double, 2, 3> d_point;
};

bool make_row(const BundleProblem& problem, const Places& places, const BundleObservation& seen,
              Row& row) {
  const auto lens =
      static_cast<std::size_t>(problem.lens_of_image[static_cast<std::size_t>(seen.image)]);
  const Eigen::VectorXd& parameters = problem.lenses[lens];
  PosedFrame pose(problem.poses[static_cast<std::size_t>(seen.image)].data());
  // Increments from the left instead of changes of the rotation vector.
  pose.left_jacobian.setIdentity();
  RowMatrix d_lens(2, parameters.size());
  Eigen::Vector2d d_zoom;
  ObservationValue value;
  if (!observe_zoomed(problem.shapes[lens], parameters.data(),
                      problem.zoom[static_cast<std::size_t>(seen.image)], pose,
                      problem.points[static_cast<std::size_t>(seen.point)], value, d_lens.data(),
                      &d_zoom))
    return false;
  const Eigen::Vector2d residual = (value.pixel_px - seen.pixel_px) / seen.sigma_px;
  const double w = std::sqrt(soften(problem.config.loss, problem.config.loss_px, residual).weight) /
                   seen.sigma_px;
  row.at.clear();
  std::vector<int> of_lens;
  for (int k = 0; k < parameters.size(); ++k) {
    const int at = places.lens[lens][static_cast<std::size_t>(k)];
    if (at < 0) continue;
    row.at.push_back(at);
    of_lens.push_back(k);
  }
  const bool zooms = places.zoom_at >= 0;
  if (zooms) row.at.push_back(places.zoom_at + seen.image);
  for (int k = 0; k < 6; ++k) row.at.push_back(places.pose(seen.image) + k);
  row.d.resize(2, static_cast<Eigen::Index>(row.at.size()));
  for (std::size_t k = 0; k < of_lens.size(); ++k)
    row.d.col(static_cast<Eigen::Index>(k)) = w * d_lens.col(of_lens[k]);
  if (zooms) row.d.col(static_cast<Eigen::Index>(of_lens.size())) = w * d_zoom;
  row.d.rightCols<6>() = w * value.d_rig_from_points;
  row.d_point = w * value.d_point;
  return true;
}

/// Adds a point's observations to the reduced system, the point eliminated.
void add_point(const std::vector<Row>& rows, const Matrix3d& prior, MatrixXd& reduced) {
  Matrix3d point = prior;
  std::map<int, Vector3d> across;  // d(parameter) d(point)
  for (const Row& row : rows) {
    point += row.d_point.transpose() * row.d_point;
    const MatrixXd own = row.d.transpose() * row.d;
    for (std::size_t a = 0; a < row.at.size(); ++a) {
      const auto ia = static_cast<Eigen::Index>(a);
      for (std::size_t b = 0; b < row.at.size(); ++b)
        reduced(row.at[a], row.at[b]) += own(ia, static_cast<Eigen::Index>(b));
      across.try_emplace(row.at[a], Vector3d::Zero()).first->second +=
          row.d_point.transpose() * row.d.col(ia);
    }
  }
  const Eigen::LDLT<Matrix3d> solver(point);
  std::vector<std::pair<int, Vector3d>> list(across.begin(), across.end());
  for (const auto& [a, of_a] : list) {
    const Vector3d gain = solver.solve(of_a);
    for (const auto& [b, of_b] : list) reduced(a, b) -= gain.dot(of_b);
  }
}

/// How the poses' increments go when the whole world is turned, moved or scaled: a column each.
MatrixXd gauge_directions(const BundleProblem& problem, const Places& places) {
  if (problem.gauge == BundleGauge::metric) return MatrixXd(places.count, 0);
  // A known distance sets the scale and bears on nothing else: the scale is held like the rest.
  MatrixXd n = MatrixXd::Zero(places.count, 7);
  for (std::size_t i = 0; i < problem.poses.size(); ++i) {
    const Pose pose = pose_of_vector(problem.poses[i]);
    const Matrix3d rotation = pose.rotation.toRotationMatrix();
    const int at = places.pose(static_cast<int>(i));
    n.block<3, 3>(at, 0) = -rotation;
    n.block<3, 3>(at + 3, 3) = -rotation;
    n.block<3, 1>(at + 3, 6) = pose.translation_m;
  }
  // An orthonormal basis of what they span.
  return Eigen::HouseholderQR<MatrixXd>(n).householderQ() * MatrixXd::Identity(n.rows(), n.cols());
}

MatrixXd reduced_system(const BundleProblem& problem, const Places& places) {
  MatrixXd reduced = MatrixXd::Zero(places.count, places.count);
  std::vector<std::vector<Row>> of_point(problem.points.size());
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    Row row;
    if (problem.used[i] && make_row(problem, places, problem.observations[i], row))
      of_point[static_cast<std::size_t>(problem.observations[i].point)].push_back(std::move(row));
  }
  std::vector<Matrix3d> prior(problem.points.size(), Matrix3d::Zero());
  for (const KnownPoint& known : problem.known_points)
    prior[static_cast<std::size_t>(known.point)] +=
        Matrix3d::Identity() / (known.sigma_m * known.sigma_m);
  for (std::size_t p = 0; p < of_point.size(); ++p) {
    if (!of_point[p].empty()) add_point(of_point[p], prior[p], reduced);
  }
  for (std::size_t l = 0; l < problem.lenses.size(); ++l) {
    for (std::size_t k = 0; k < places.lens[l].size(); ++k) {
      const double sigma = problem.prior_sigma[l][static_cast<Eigen::Index>(k)];
      if (places.lens[l][k] >= 0 && std::isfinite(sigma))
        reduced(places.lens[l][k], places.lens[l][k]) += 1 / (sigma * sigma);
    }
  }
  for (int at = places.zoom_at; at >= 0 && at < places.count; ++at)
    reduced(at, at) += 1 / (problem.config.zoom_share * problem.config.zoom_share);
  return reduced;
}

/// Rows that take changes of all parameters to those of the lenses' free ones: a focal length that
/// is the mean of its images' changes with their zooms, which are 1 in the mean.
MatrixXd to_lenses(const BundleProblem& problem, const Places& places) {
  MatrixXd rows = MatrixXd::Zero(places.lens_count, places.count);
  rows.leftCols(places.lens_count).setIdentity();
  if (places.zoom_at < 0) return rows;
  std::vector<int> images(problem.lenses.size(), 0);
  for (const int lens : problem.lens_of_image) ++images[static_cast<std::size_t>(lens)];
  for (std::size_t i = 0; i < problem.lens_of_image.size(); ++i) {
    const auto lens = static_cast<std::size_t>(problem.lens_of_image[i]);
    for (std::size_t k = 0; k < 2; ++k) {  // fx, fy
      if (places.lens[lens][0] < 0 || places.lens[lens][1] < 0) continue;
      rows(places.lens[lens][k], places.zoom_at + static_cast<int>(i)) +=
          problem.lenses[lens][static_cast<Eigen::Index>(k)] / images[lens];
    }
  }
  return rows;
}

}  // namespace

BundleCovariance bundle_covariance(const BundleProblem& problem) {
  const Places places(problem);
  BundleCovariance result;
  MatrixXd reduced = reduced_system(problem, places);
  const Eigen::VectorXd diagonal = reduced.diagonal();
  if (!(diagonal.array() > 0).all()) return result;
  // Unit diagonal, so that pixels, radians and lengths compare.
  const Eigen::VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
  reduced = scale.asDiagonal() * reduced * scale.asDiagonal();
  MatrixXd gauge = gauge_directions(problem, places);
  gauge = scale.cwiseInverse().asDiagonal() * gauge;
  if (gauge.cols() > 0) {
    gauge = Eigen::HouseholderQR<MatrixXd>(gauge).householderQ() *
            MatrixXd::Identity(gauge.rows(), gauge.cols());
  }
  MatrixXd held = reduced + gauge * gauge.transpose();
  const Eigen::LLT<MatrixXd> solver(held);
  constexpr double kLeastCondition = 1e-14;
  if (solver.info() != Eigen::Success || solver.rcond() < kLeastCondition) return result;
  MatrixXd inverse = solver.solve(MatrixXd::Identity(places.count, places.count));
  inverse -= gauge * gauge.transpose();
  inverse = scale.asDiagonal() * inverse * scale.asDiagonal();
  // From the gauge of the scaled system to that of least trace over the poses' own increments.
  const MatrixXd basis = gauge_directions(problem, places);
  if (basis.cols() > 0) {
    const MatrixXd left = inverse - basis * (basis.transpose() * inverse);
    inverse = left - (left * basis) * basis.transpose();
  }
  result.solved = true;
  const MatrixXd rows = to_lenses(problem, places);
  result.lens = rows * inverse * rows.transpose();
  for (std::size_t i = 0; i < problem.poses.size(); ++i) {
    const int at = places.pose(static_cast<int>(i));
    result.poses.emplace_back(inverse.block<6, 6>(at, at));
  }
  return result;
}

Eigen::Vector2d bundle_residual(const BundleProblem& problem, const BundleObservation& seen) {
  const auto lens =
      static_cast<std::size_t>(problem.lens_of_image[static_cast<std::size_t>(seen.image)]);
  const PosedFrame pose(problem.poses[static_cast<std::size_t>(seen.image)].data());
  ObservationValue value;
  if (!observe_zoomed(problem.shapes[lens], problem.lenses[lens].data(),
                      problem.zoom[static_cast<std::size_t>(seen.image)], pose,
                      problem.points[static_cast<std::size_t>(seen.point)], value, nullptr,
                      nullptr))
    return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  return (value.pixel_px - seen.pixel_px) / seen.sigma_px;
}

}  // namespace cousin
