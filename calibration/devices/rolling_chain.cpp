#include "calibration/devices/rolling_chain.h"

#include <Eigen/Cholesky>

namespace cousin {

ChainFactor::ChainFactor(const FrameChain& chain) : next_(chain.next) {
  for (std::size_t i = 0; i < chain.own.size(); ++i) {
    Matrix12d pivot = chain.own[i];
    if (i > 0) pivot -= next_[i - 1].transpose() * inverse_pivots_[i - 1] * next_[i - 1];
    // Scaled to a unit diagonal: radians, lengths and speeds differ by orders of magnitude.
    const Eigen::Matrix<double, 12, 1> scale = pivot.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::LLT<Matrix12d> llt(Matrix12d(scale.asDiagonal() * pivot * scale.asDiagonal()));
    ok_ = ok_ && scale.allFinite() && llt.info() == Eigen::Success;
    if (!ok_) return;
    inverse_pivots_.emplace_back(scale.asDiagonal() * llt.solve(Matrix12d::Identity()) *
                                 scale.asDiagonal());
  }
}

Eigen::MatrixXd ChainFactor::solve(const Eigen::MatrixXd& right) const {
  Eigen::MatrixXd x = right;
  const std::size_t n = inverse_pivots_.size();
  const auto rows = [&](std::size_t i) {
    return x.middleRows<12>(12 * static_cast<Eigen::Index>(i));
  };
  for (std::size_t i = 1; i < n; ++i)
    rows(i) -= next_[i - 1].transpose() * (inverse_pivots_[i - 1] * rows(i - 1));
  for (std::size_t i = n; i-- > 0;) {
    Eigen::MatrixXd own = rows(i);
    if (i + 1 < n) own -= next_[i] * rows(i + 1);
    rows(i) = inverse_pivots_[i] * own;
  }
  return x;
}

FrameChain ChainFactor::inverse_blocks() const {
  FrameChain inverse;
  const std::size_t n = inverse_pivots_.size();
  inverse.own.resize(n);
  inverse.next.resize(n > 0 ? n - 1 : 0);
  for (std::size_t i = n; i-- > 0;) {
    inverse.own[i] = inverse_pivots_[i];
    if (i + 1 == n) continue;
    const Matrix12d gain = inverse_pivots_[i] * next_[i];
    inverse.next[i] = -gain * inverse.own[i + 1];
    inverse.own[i] -= inverse.next[i] * gain.transpose();
  }
  return inverse;
}

}  // namespace cousin
