#include "benchmarks/tools/fit_sensor/photon_transfer_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "benchmarks/score/distributions.h"
#include "benchmarks/tools/fit_sensor/tile_regression.h"

namespace cousin {
namespace {

constexpr double kRounding = 1.0 / 12;
constexpr double kClipped = 1e-3;        ///< share of pixels at an end that spoils a level
constexpr double kPiledUp = 0.01;        ///< share of pixels at a frame's own largest code
constexpr double kLeastVariance = 0.25;  ///< codes^2; below, rounding is no noise of 1/12

void check_size(const FlatFrames& flat, int k, const Image<std::uint16_t>& first,
                const Image<std::uint16_t>& image) {
  if (image.width() == first.width() && image.height() == first.height()) return;
  throw std::runtime_error(flat.name + ": frame " + std::to_string(k) + " has " +
                           std::to_string(image.width()) + " x " + std::to_string(image.height()) +
                           " pixels; the first has " + std::to_string(first.width()) + " x " +
                           std::to_string(first.height()));
}

/// Frames 0 and 1, 2 and 3, ...
FlatLevel level_of(const FlatFrames& flat, int max_code) {
  if (flat.count < 2)
    throw std::runtime_error(flat.name + ": " + std::to_string(flat.count) +
                             " frames; at least 2 are needed");
  FlatLevel level;
  level.name = flat.name;
  std::vector<double> squares, counts;
  double sum = 0, pixels = 0, high = 0, zero = 0, drift = 0, at_top = 0;
  int top = -1;
  Image<std::uint16_t> first;
  for (int k = 0; k + 1 < flat.count; k += 2) {
    const Image<std::uint16_t> a = flat.frame(k), b = flat.frame(k + 1);
    if (k == 0) first = a;
    check_size(flat, k, first, a);
    check_size(flat, k + 1, first, b);
    squares.resize(static_cast<std::size_t>(a.height()), 0);
    counts.resize(squares.size(), 0);
    double difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i) difference += a.data()[i] - b.data()[i];
    // Light that flickers shifts a whole frame.
    const double mean = difference / static_cast<double>(a.size());
    drift = std::max(drift, std::abs(mean));
    for (int y = 0; y < a.height(); ++y) {
      for (int x = 0; x < a.width(); ++x) {
        const int p = a(x, y), q = b(x, y);
        const double d = p - q - mean;
        squares[static_cast<std::size_t>(y)] += 0.5 * d * d;
        sum += 0.5 * (p + q);
        high += (p >= max_code) + (q >= max_code);
        if (std::max(p, q) > top) {
          top = std::max(p, q);
          at_top = 0;
        }
        at_top += (p == top) + (q == top);
        zero += (p == 0) + (q == 0);
      }
      counts[static_cast<std::size_t>(y)] += a.width();
    }
    pixels += static_cast<double>(a.size());
  }
  level.mean = sum / pixels;
  const TileRatio variance = tile_ratio(squares, counts);
  level.variance = {variance.value, variance.sigma};
  // A sensor may saturate below the largest code of its files: then its largest code is common.
  level.saturated = (at_top > kPiledUp * 2 * pixels ? at_top : high) / (2 * pixels);
  level.at_zero = zero / (2 * pixels);
  if (drift > 0.05 * std::max(level.mean, 1.0) && drift > 5)
    level.left_out = "its brightness changes between frames";
  return level;
}

/// A point of the line and the relative error of its variance.
struct Point {
  double mean, variance, error;
};

struct Line {
  Eigen::Vector2d terms = Eigen::Vector2d::Zero();  ///< slope, intercept
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  double chi2 = 0, misfit = 0;
};

/// Weighted by what the line says, in turns: weights by the measured variance would favour the low
/// ones.
Line fit_line(const std::vector<Point>& points) {
  Line line;
  for (int turn = 0; turn < 4; ++turn) {
    Eigen::Matrix2d a = Eigen::Matrix2d::Zero();
    Eigen::Vector2d b = Eigen::Vector2d::Zero();
    line.chi2 = line.misfit = 0;
    for (const Point& p : points) {
      const Eigen::Vector2d row(p.mean, 1);
      double expected = turn == 0 ? p.variance : row.dot(line.terms);
      if (!(expected > 0)) expected = p.variance;
      const double weight = std::pow(expected * p.error, -2);
      a += weight * row * row.transpose();
      b += weight * p.variance * row;
    }
    line.covariance = a.inverse();
    line.terms = line.covariance * b;
    for (const Point& p : points) {
      const double expected = p.mean * line.terms(0) + line.terms(1);
      line.chi2 += std::pow((p.variance / expected - 1) / p.error, 2);
      line.misfit += std::pow(p.variance / expected - 1, 2) / static_cast<double>(points.size());
    }
  }
  line.misfit = std::sqrt(line.misfit);
  return line;
}

std::string shares(const char* format, double a) {
  char text[200];
  std::snprintf(text, sizeof text, format, a);
  return text;
}

void choose_levels(GainFit& fit) {
  for (FlatLevel& level : fit.flats) {
    if (!level.left_out.empty()) continue;
    if (level.saturated > kClipped)
      level.left_out =
          shares("%.1f %% of its pixels are saturated (limit 0.1 %%)", 100 * level.saturated);
    else if (level.at_zero > kClipped)
      level.left_out = shares("%.1f %% of its pixels are 0 (limit 0.1 %%)", 100 * level.at_zero);
    else if (level.variance.value < kLeastVariance)
      level.left_out = "its noise spans less than half a code";
    else if (level.mean <= fit.black_code)
      level.left_out = "it is not brighter than the dark frames";
  }
}

WithInterval interval(double value, double sigma) {
  return {value, value - kSigmas95 * sigma, value + kSigmas95 * sigma};
}

void set_read_noise(const Line& line, double widening, GainFit& fit) {
  const double variance = line.terms(1) - kRounding;
  fit.read_noise_solved = fit.dark.left_out.empty() && variance > 0;
  if (!fit.read_noise_solved) return;
  const double k = line.terms(0), read = std::sqrt(variance) / k;
  const Eigen::Vector2d gradient(-read / k, 1 / (2 * k * std::sqrt(variance)));
  fit.read_noise_e = interval(read, std::sqrt(widening * gradient.dot(line.covariance * gradient)));
}

}  // namespace

GainFit fit_gain(const FlatFrames& dark, const std::vector<FlatFrames>& flats, int max_code) {
  GainFit fit;
  fit.dark = level_of(dark, max_code);
  for (const FlatFrames& flat : flats) fit.flats.push_back(level_of(flat, max_code));
  fit.black_code = fit.dark.mean;
  choose_levels(fit);
  std::vector<Point> points;
  const auto add = [&](const FlatLevel& level) {
    points.push_back({level.mean - fit.black_code, level.variance.value,
                      std::max(level.variance.sigma / level.variance.value, 1e-4)});
  };
  if (fit.dark.at_zero > kClipped) {
    fit.problems.push_back(dark.name + shares(": %.1f %% of its pixels are 0 (limit 0.1 %%): the "
                                              "camera cuts the noise off at black",
                                              100 * fit.dark.at_zero));
    return fit;
  }
  if (fit.dark.variance.value < kLeastVariance)
    fit.dark.left_out = "its noise spans less than half a code";
  std::string out;
  for (const FlatLevel& level : fit.flats) {
    if (level.left_out.empty())
      add(level);
    else
      out += "; " + level.name + ": " + level.left_out;
  }
  if (points.size() < static_cast<std::size_t>(kLeastFlats)) {
    fit.problems.push_back(std::to_string(points.size()) + " usable brightnesses; at least " +
                           std::to_string(kLeastFlats) + " flat_* folders are needed" + out);
    return fit;
  }
  if (fit.dark.left_out.empty()) add(fit.dark);
  const Line line = fit_line(points);
  fit.chi2 = line.chi2;
  fit.degrees = static_cast<int>(points.size()) - 2;
  fit.p = chi_square_above(fit.chi2, fit.degrees);
  fit.misfit = line.misfit;
  const double widening = std::max(1.0, fit.chi2 / fit.degrees);
  fit.gain = interval(line.terms(0), std::sqrt(widening * line.covariance(0, 0)));
  if (!(fit.gain.low > 0)) {
    fit.problems.push_back("the noise does not grow with the light: these frames are not raw");
    return fit;
  }
  set_read_noise(line, widening, fit);
  if (fit.p < 1e-3 && fit.misfit > 0.02)
    fit.problems.push_back(
        shares("the variance is no straight line over the mean: off by %.1f %% (limit 2 %%)",
               100 * fit.misfit) +
        shares(", p = %.1g: the frames are not linear, or denoised", fit.p));
  return fit;
}

}  // namespace cousin
