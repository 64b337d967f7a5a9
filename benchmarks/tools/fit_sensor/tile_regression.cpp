#include "benchmarks/tools/fit_sensor/tile_regression.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace cousin {
namespace {

using Terms = std::span<const int>;

Eigen::MatrixXd picked(
    const Eigen::Matrix<double, TileRegression::kTerms, TileRegression::kTerms>& a, Terms terms) {
  const auto n = static_cast<Eigen::Index>(terms.size());
  Eigen::MatrixXd out(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j)
      out(i, j) = a(terms[static_cast<std::size_t>(i)], terms[static_cast<std::size_t>(j)]);
  }
  return out;
}

Eigen::VectorXd picked(const TileRegression::Row& b, Terms terms) {
  const auto n = static_cast<Eigen::Index>(terms.size());
  Eigen::VectorXd out(n);
  for (Eigen::Index i = 0; i < n; ++i) out(i) = b(terms[static_cast<std::size_t>(i)]);
  return out;
}

}  // namespace

void TileRegression::add(std::size_t tile, const Row& row, double value) {
  Sums& s = tiles_[tile];
  s.rows.noalias() += row * row.transpose();
  s.values += value * row;
  s.squares += value * value;
  s.pixels += 1;
}

TileRegression::Fit TileRegression::fit(std::span<const int> terms) const {
  const auto n = static_cast<Eigen::Index>(terms.size());
  Fit fit;
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  for (const Sums& s : tiles_) {
    a += picked(s.rows, terms);
    b += picked(s.values, terms);
    fit.pixels += s.pixels;
  }
  const Eigen::LDLT<Eigen::MatrixXd> solver(a);
  fit.coefficients = solver.solve(b);
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(n, n);
  double used = 0;
  for (const Sums& s : tiles_) {
    const Eigen::MatrixXd rows = picked(s.rows, terms);
    const Eigen::VectorXd values = picked(s.values, terms);
    const Eigen::VectorXd score = values - rows * fit.coefficients;
    scores += score * score.transpose();
    used += s.pixels > 0 ? 1 : 0;
    fit.squares.push_back(std::max(0.0, s.squares - 2 * fit.coefficients.dot(values) +
                                            fit.coefficients.dot(rows * fit.coefficients)));
  }
  // As many tiles as terms less one leave nothing to judge by.
  const double freedom = std::max(1.0, used - static_cast<double>(n));
  fit.covariance = solver.solve(solver.solve(scores).transpose()) * (used / freedom);
  return fit;
}

double TileRegression::separation(std::span<const int> terms) const {
  const auto n = static_cast<Eigen::Index>(terms.size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  for (const Sums& s : tiles_) a += picked(s.rows, terms);
  const Eigen::VectorXd scale = a.diagonal();
  if (!(scale.minCoeff() > 0)) return 0;
  const Eigen::VectorXd inverse = scale.cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd correlation = inverse.asDiagonal() * a * inverse.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(correlation).eigenvalues().minCoeff();
}

TileRatio tile_ratio(std::span<const double> numerator, std::span<const double> denominator) {
  double top = 0, bottom = 0, used = 0;
  for (std::size_t i = 0; i < numerator.size(); ++i) {
    top += numerator[i];
    bottom += denominator[i];
    used += denominator[i] > 0 ? 1 : 0;
  }
  if (!(bottom > 0)) return {};
  TileRatio ratio{top / bottom, 0};
  double squares = 0;
  for (std::size_t i = 0; i < numerator.size(); ++i) {
    const double score = numerator[i] - ratio.value * denominator[i];
    squares += score * score;
  }
  if (used > 1) ratio.sigma = std::sqrt(squares * used / (used - 1)) / bottom;
  return ratio;
}

}  // namespace cousin
