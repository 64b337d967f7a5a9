#include "calibration/solve/board_scale.h"

#include <Eigen/Dense>
#include <cmath>
#include <set>

namespace cousin {

BoardScale scale_from_board(const std::vector<ModelCorner>& corners,
                            const std::vector<Eigen::Vector3d>& target_m) {
  BoardScale scale;
  scale.corners = static_cast<int>(corners.size());
  const auto fail = [&](CalibrationStatus status, const std::string& reason) {
    scale.status = status;
    scale.reason = reason;
    return scale;
  };
  std::set<int> ids;
  for (const ModelCorner& c : corners) {
    const std::string name = "corner " + std::to_string(c.id);
    if (c.id < 0 || c.id >= static_cast<int>(target_m.size()))
      return fail(CalibrationStatus::bad_input,
                  name + " is not one of the target's " + std::to_string(target_m.size()));
    if (!ids.insert(c.id).second)
      return fail(CalibrationStatus::bad_input, name + " is given twice");
    if (!c.in_model.allFinite()) return fail(CalibrationStatus::bad_input, name + " is not finite");
  }
  constexpr int kLeast = 4;
  if (scale.corners < kLeast)
    return fail(CalibrationStatus::not_determined,
                std::to_string(scale.corners) + " corners, at least 4 are needed");
  const auto n = static_cast<Eigen::Index>(corners.size());
  Eigen::Matrix3Xd board(3, n), model(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ModelCorner& c = corners[static_cast<std::size_t>(i)];
    board.col(i) = target_m[static_cast<std::size_t>(c.id)];
    model.col(i) = c.in_model;
  }
  board.colwise() -= board.rowwise().mean().eval();
  model.colwise() -= model.rowwise().mean().eval();
  const Eigen::Vector3d spread =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(board * board.transpose()).eigenvalues();
  if (!(spread(1) > 1e-8 * spread(2)))
    return fail(CalibrationStatus::not_determined, "the corners lie on a line");

  // Errors are the model's: model = k R board, so that k is the units a metre.
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(model * board.transpose(),
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign.z() = -1;
  const Eigen::Matrix3d rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  const double size = board.squaredNorm();
  const double k = svd.singularValues().dot(sign) / size;
  if (!(k > 0)) return fail(CalibrationStatus::not_determined, "the model's corners coincide");
  const double squares = (model - k * rotation * board).squaredNorm();
  constexpr double kFreedoms = 7;
  const double variance = squares / (3.0 * static_cast<double>(n) - kFreedoms);
  scale.status = CalibrationStatus::ok;
  scale.m_per_unit = 1 / k;
  scale.sigma = std::sqrt(variance / size) / (k * k);
  scale.rms_m = std::sqrt(squares / (3.0 * static_cast<double>(n))) / k;
  return scale;
}

}  // namespace cousin
