#include "sim/dataset/json_covariance.h"

#include <Eigen/Cholesky>

namespace cousin {

Eigen::MatrixXd covariance_from(const JsonNode& node, Eigen::Index n) {
  const auto count = static_cast<std::size_t>(n * n);
  const std::vector<double> values = node.numbers(count, count);
  if (n == 0) return {};
  const Eigen::MatrixXd covariance = Eigen::Map<const Eigen::MatrixXd>(values.data(), n, n);
  if ((covariance - covariance.transpose()).cwiseAbs().maxCoeff() >
      1e-9 * covariance.cwiseAbs().maxCoeff())
    node.fail("is not symmetric");
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  if ((covariance.diagonal().array() < 0).any()) node.fail("has a negative variance");
  const Eigen::VectorXd inverse = sigma.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  Eigen::MatrixXd correlation = inverse.asDiagonal() * covariance * inverse.asDiagonal();
  correlation.diagonal().array() += 1e-9;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (sigma[i] == 0) correlation(i, i) = 1;
  }
  if (!correlation.allFinite() || correlation.llt().info() != Eigen::Success)
    node.fail("is not a covariance: it is not positive semi-definite");
  return covariance;
}

}  // namespace cousin
