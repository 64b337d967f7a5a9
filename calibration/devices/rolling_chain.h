#pragma once

#include <Eigen/Core>
#include <vector>

namespace cousin {

using Matrix12d = Eigen::Matrix<double, 12, 12>;

/// A symmetric positive definite matrix of 12 x 12 blocks, of which only neighbours couple: the
/// frames of a video. Private to calibration.
struct FrameChain {
  std::vector<Matrix12d> own;   ///< on the diagonal
  std::vector<Matrix12d> next;  ///< block (i, i + 1); one fewer than `own`
};

/// Its factor: D(0) = own(0), D(i + 1) = own(i + 1) - next(i)' D(i)^-1 next(i).
class ChainFactor {
 public:
  explicit ChainFactor(const FrameChain& chain);
  /// False where a pivot is not positive definite: then nothing else may be asked.
  bool ok() const { return ok_; }
  /// chain^-1 right; `right` has 12 rows a frame.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const;
  /// The inverse's blocks in the places of the chain's.
  FrameChain inverse_blocks() const;

 private:
  bool ok_ = true;
  std::vector<Matrix12d> inverse_pivots_;
  std::vector<Matrix12d> next_;
};

}  // namespace cousin
