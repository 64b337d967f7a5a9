#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace cousin {

/// Linear least squares over pixels in tiles, with standard errors that hold if pixels of a tile
/// depend on each other: the covariance of the coefficients from the tiles' scores [Liang & Zeger
/// 1986, "sandwich"].
class TileRegression {
 public:
  static constexpr int kTerms = 8;
  using Row = Eigen::Matrix<double, kTerms, 1>;

  explicit TileRegression(std::size_t tiles) : tiles_(tiles) {}
  void add(std::size_t tile, const Row& row, double value);

  struct Fit {
    Eigen::VectorXd coefficients;
    Eigen::MatrixXd covariance;
    std::vector<double> squares;  ///< of the residuals, a tile each
    double pixels = 0;
  };
  /// With these terms of the rows only.
  Fit fit(std::span<const int> terms) const;
  /// Least eigenvalue of the terms' correlation matrix: near 0 where they cannot be told apart.
  double separation(std::span<const int> terms) const;
  double pixels(std::size_t tile) const { return tiles_[tile].pixels; }

 private:
  struct Sums {
    Eigen::Matrix<double, kTerms, kTerms> rows = Eigen::Matrix<double, kTerms, kTerms>::Zero();
    Row values = Row::Zero();
    double squares = 0, pixels = 0;
  };
  std::vector<Sums> tiles_;
};

/// Sum over tiles of `numerator` over that of `denominator`, with the standard error of a ratio of
/// cluster sums; zero where the denominator is.
struct TileRatio {
  double value = 0, sigma = 0;
};
TileRatio tile_ratio(std::span<const double> numerator, std::span<const double> denominator);

}  // namespace cousin
