#include "perception/stereo/row_alignment.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <vector>

#include "sim/types/no_value.h"

namespace cousin {
namespace {

constexpr int kWindowRadius = 4;
constexpr int kMostWindows = 3000;
constexpr int kLeastWindows = 20;       ///< that say anything
constexpr double kMostSpread_px = 0.5;  ///< of windows that agree
constexpr int kEnoughWindows = 100;     ///< of which more than a shift is believed

/// One window's word.
struct WindowOffset {
  double x = 0, y = 0;  ///< in the right image, in half widths from its middle
  double down_px = 0;
};

/// Bilinear value of an image, which must hold a pixel more on every side.
double value_at(const Image<float>& image, double x, double y) {
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const double a = x - i, b = y - j;
  return (1 - b) * ((1 - a) * image(i, j) + a * image(i + 1, j)) +
         b * ((1 - a) * image(i, j + 1) + a * image(i + 1, j + 1));
}

/// Where the right image shows the window about a left pixel, by least squares over both axes, gain
/// and offset of the brightness.
std::optional<WindowOffset> offset_of_window(const Image<float>& left, const Image<float>& right,
                                             int x, int y, double disparity_px) {
  constexpr int kSteps = 8;
  constexpr double kMostMoved_px = 2.5, kLeastLikeness = 0.8, kMostSigma_px = 0.15;
  const int r = kWindowRadius;
  double dx = 0, dy = 0;
  for (int step = 0; step < kSteps; ++step) {
    const double there_x = x - disparity_px + dx, there_y = y + dy;
    if (!(there_x >= r + 2 && there_y >= r + 2 && there_x <= right.width() - r - 3 &&
          there_y <= right.height() - r - 3))
      return std::nullopt;
    Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
    Eigen::Vector4d vector = Eigen::Vector4d::Zero();
    double n = 0, l = 0, ll = 0, lr = 0;
    for (int v = -r; v <= r; ++v) {
      for (int u = -r; u <= r; ++u) {
        const double px = there_x + u, py = there_y + v;
        const double value = value_at(right, px, py);
        const Eigen::Vector4d row(0.5 * (value_at(right, px + 1, py) - value_at(right, px - 1, py)),
                                  0.5 * (value_at(right, px, py + 1) - value_at(right, px, py - 1)),
                                  value, 1);
        const double own = left(x + u, y + v);
        normal += row * row.transpose();
        vector += own * row;
        n += 1;
        l += own;
        ll += own * own;
        lr += own * value;
      }
    }
    const double variance_l = ll - l * l / n,
                 variance_r = normal(2, 2) - normal(2, 3) * normal(2, 3) / n;
    const Eigen::LDLT<Eigen::Matrix4d> solver(normal);
    if (!(variance_l > 0 && variance_r > 0) || solver.info() != Eigen::Success) return std::nullopt;
    const Eigen::Vector4d solution = solver.solve(vector);
    const double gain = solution[2];
    if (!(gain > 0.1) || !solution.allFinite()) return std::nullopt;
    const Eigen::Vector2d move = solution.head<2>() / gain;
    dx += std::clamp(move.x(), -0.7, 0.7);
    dy += std::clamp(move.y(), -0.7, 0.7);
    if (std::abs(dx) > kMostMoved_px || std::abs(dy) > kMostMoved_px) return std::nullopt;
    if (step + 1 < kSteps && move.cwiseAbs().maxCoeff() > 0.01) continue;
    const double likeness = (lr - l * normal(2, 3) / n) / std::sqrt(variance_l * variance_r);
    const double squares = std::max(0.0, ll - solution.dot(vector));
    const Eigen::Matrix4d covariance =
        solver.solve(Eigen::Matrix4d::Identity()) * (squares / (n - 4) / (gain * gain));
    if (likeness < kLeastLikeness || !(covariance(1, 1) < kMostSigma_px * kMostSigma_px))
      return std::nullopt;
    const double half = 0.5 * right.width();
    return WindowOffset{(x - disparity_px + dx - 0.5 * (right.width() - 1)) / half,
                        (y + dy - 0.5 * (right.height() - 1)) / half, dy};
  }
  return std::nullopt;
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

using Terms = Eigen::Matrix<double, RowOffset::kTerms, 1>;

/// At a place in half widths from the middle.
Terms terms_at(double x, double y) {
  Terms terms;
  terms << 1, x, y, x * x, x * y, y * y, y * (x * x + y * y);
  return terms;
}

double at_place(const RowOffset& offset, double x, double y) {
  return Eigen::Map<const Terms>(offset.terms_px.data()).dot(terms_at(x, y));
}

double spread_about(const RowOffset& offset, const std::vector<WindowOffset>& windows) {
  std::vector<double> off_px;
  for (const WindowOffset& w : windows)
    off_px.push_back(std::abs(w.down_px - at_place(offset, w.x, w.y)));
  return 1.4826 * median_of(std::move(off_px));
}

/// A polynomial through most of the windows, by weights that fall to zero [Tukey's biweight]. The
/// higher terms are held to zero by a prior, for where there are no windows nothing else does.
RowOffset fit_to(const std::vector<WindowOffset>& windows) {
  RowOffset offset;
  if (windows.size() < kLeastWindows) return offset;
  std::vector<double> down_px;
  for (const WindowOffset& w : windows) down_px.push_back(w.down_px);
  offset.terms_px[0] = median_of(std::move(down_px));
  offset.windows = static_cast<int>(windows.size());
  offset.spread_px = spread_about(offset, windows);
  if (windows.size() < kEnoughWindows) return offset;
  constexpr int kRounds = 10;
  constexpr double kPrior = 0.0005;  // of the windows' weight
  for (int round = 0; round < kRounds; ++round) {
    const double reach_px = 4.7 * std::max(offset.spread_px, 0.02);
    Eigen::Matrix<double, RowOffset::kTerms, RowOffset::kTerms> normal;
    normal.setZero();
    Terms vector = Terms::Zero();
    double weights = 0;
    for (const WindowOffset& w : windows) {
      const double t = (w.down_px - at_place(offset, w.x, w.y)) / reach_px;
      if (!(std::abs(t) < 1)) continue;
      const double weight = (1 - t * t) * (1 - t * t);
      const Terms row = terms_at(w.x, w.y);
      normal += weight * row * row.transpose();
      vector += weight * w.down_px * row;
      weights += weight;
    }
    for (int i = 1; i < RowOffset::kTerms; ++i) normal(i, i) += kPrior * weights;
    const Terms terms = normal.ldlt().solve(vector);
    if (!terms.allFinite()) return offset;
    Eigen::Map<Terms>(offset.terms_px.data()) = terms;
    offset.spread_px = spread_about(offset, windows);
  }
  return offset;
}

}  // namespace

double row_offset_px(const RowOffset& offset, int width, int height, double x, double y) {
  const double half = 0.5 * width;
  return at_place(offset, (x - 0.5 * (width - 1)) / half, (y - 0.5 * (height - 1)) / half);
}

RowOffsetSize size_of(const RowOffset& offset, int width, int height) {
  constexpr int kPlaces = 16;  // along either side
  RowOffsetSize size;
  for (int j = 0; j <= kPlaces; ++j) {
    for (int i = 0; i <= kPlaces; ++i) {
      const double x = static_cast<double>(i) / kPlaces * (width - 1),
                   y = static_cast<double>(j) / kPlaces * (height - 1);
      const double px = row_offset_px(offset, width, height, x, y);
      size.rms_px += px * px / ((kPlaces + 1) * (kPlaces + 1));
      size.largest_px = std::max(size.largest_px, std::abs(px));
    }
  }
  size.rms_px = std::sqrt(size.rms_px);
  return size;
}

RowOffset scaled(RowOffset offset, double factor) {
  for (double& term : offset.terms_px) term *= factor;
  offset.spread_px *= factor;
  return offset;
}

RowOffset find_row_offset(const Image<float>& left, const Image<float>& right,
                          const Image<float>& disparity_px, const RowOffset& known) {
  const auto same_size = [&](const Image<float>& image) {
    return image.width() == left.width() && image.height() == left.height();
  };
  if (!same_size(right) || !same_size(disparity_px))
    throw std::invalid_argument("find_row_offset: images and disparities differ in size");
  const int r = kWindowRadius;
  std::vector<Eigen::Vector2i> places;
  for (int y = r; y < left.height() - r; ++y) {
    for (int x = r; x < left.width() - r; ++x) {
      if (std::isfinite(disparity_px(x, y))) places.push_back({x, y});
    }
  }
  const std::size_t count = std::min<std::size_t>(places.size(), kMostWindows);
  std::vector<std::optional<WindowOffset>> found(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    const Eigen::Vector2i& at = places[i * places.size() / count];
    found[i] = offset_of_window(left, right, at.x(), at.y(),
                                static_cast<double>(disparity_px(at.x(), at.y())));
  });
  std::vector<WindowOffset> windows;
  for (const auto& window : found) {
    if (!window) continue;
    windows.push_back(*window);
    windows.back().down_px += at_place(known, window->x, window->y);
  }
  const RowOffset offset = fit_to(windows);
  return offset.spread_px <= kMostSpread_px ? offset : RowOffset{};
}

Image<Eigen::Vector2f> with_rows_moved(const Image<Eigen::Vector2f>& right_px,
                                       const RowOffset& offset) {
  const int width = right_px.width(), height = right_px.height();
  Image<Eigen::Vector2f> moved(width, height, Eigen::Vector2f(kNone, kNone));
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const double from = y + row_offset_px(offset, width, height, x, y);
      if (!(from >= 0 && from <= height - 1)) continue;
      const int above = static_cast<int>(from), below = std::min(above + 1, height - 1);
      const auto part = static_cast<float>(from - above);
      moved(x, y) = (1 - part) * right_px(x, above) + part * right_px(x, below);
    }
  });
  return moved;
}

}  // namespace cousin
