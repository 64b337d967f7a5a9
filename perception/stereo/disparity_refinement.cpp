#include "perception/stereo/disparity_refinement.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "sim/types/no_value.h"

namespace cousin {
namespace {

/// Value and slope between pixels of a row, by the cubic through four of them [Catmull & Rom 1974].
struct RowSample {
  float value, slope;
};
RowSample sample_row(const float* row, int width, float x) {
  const int i = std::clamp(static_cast<int>(x), 1, width - 3);
  const float t = x - static_cast<float>(i);
  const float a = row[i - 1], b = row[i], c = row[i + 1], d = row[i + 2];
  const float c1 = 0.5F * (c - a), c2 = a - 2.5F * b + 2 * c - 0.5F * d,
              c3 = 0.5F * (d - a) + 1.5F * (b - c);
  return {b + t * (c1 + t * (c2 + t * c3)), c1 + t * (2 * c2 + 3 * t * c3)};
}

/// Sums over a window of what the fit of (disparity, gain, offset) reads.
struct WindowSums {
  float w = 0, l = 0, r = 0, s = 0, t = 0, ll = 0, rr = 0, ss = 0, lr = 0, ls = 0, rs = 0, st = 0;
  int pixels = 0;
  /// @param left  brightness and slope
  void add(float weight, RowSample left, RowSample right) {
    w += weight;
    const float wl = weight * left.value, wr = weight * right.value, ws = weight * right.slope;
    l += wl;
    r += wr;
    s += ws;
    t += weight * left.slope;
    ll += wl * left.value;
    rr += wr * right.value;
    ss += ws * right.slope;
    lr += wl * right.value;
    ls += wl * right.slope;
    rs += wr * right.slope;
    st += ws * left.slope;
    ++pixels;
  }
};

/// What one step of the least squares says.
struct WindowFit {
  bool ok = false;
  float step_px = 0, variance_px2 = 0, likeness = 0, gain = 0, residual = 0;
};

/// Residuals left - gain right(x - d) - offset, about which means are taken out.
WindowFit fit_window(const WindowSums& m) {
  WindowFit fit;
  if (!(m.w > 0) || m.pixels < 8) return fit;
  const float ll = m.ll - m.l * m.l / m.w, rr = m.rr - m.r * m.r / m.w, ss = m.ss - m.s * m.s / m.w,
              lr = m.lr - m.l * m.r / m.w, ls = m.ls - m.l * m.s / m.w, rs = m.rs - m.r * m.s / m.w;
  if (!(ll > 0) || !(rr > 0)) return fit;
  fit.likeness = lr / std::sqrt(ll * rr);
  // left = gain right - (gain step) slope: unknowns gain and p = gain step.
  const float determinant = rr * ss - rs * rs;
  if (!(determinant > 1e-4F * rr * ss)) return fit;
  const float gain = (lr * ss - ls * rs) / determinant;
  const float p = -(ls * rr - lr * rs) / determinant;
  if (!(gain > 0.1F)) return fit;
  // Noise has slopes too, and they promise what only those that both images show can keep: the
  // curvature of the squares is that of the slopes' product.
  const float shared = (m.st - m.s * m.t / m.w) / gain;
  if (!(shared > 0.1F * ss)) return fit;
  const float promised = std::max(1.0F, ss / shared);
  fit.gain = gain;
  fit.step_px = promised * p / gain;
  const float squares = std::max(0.0F, ll - gain * lr + p * ls);
  const float freedom = m.w * (1 - 3 / static_cast<float>(m.pixels));
  fit.variance_px2 = squares / freedom * rr / determinant / (gain * gain) * promised;
  fit.residual = std::sqrt(squares / freedom);
  fit.ok = true;
  return fit;
}

struct RefinedWindow {
  float disparity_px = kNone, sigma_px = kNone, gain = 0, residual = 0;
};

/// How alike the noise of neighbouring pixels is, over many windows: demosaicing, denoising and
/// resampling spread it, and the gradients it is held against are smooth too. Least squares that
/// take pixels for independent then promise too much.
struct NoiseLikeness {
  static constexpr int kReach_px = 4;
  static constexpr int kLags = (kReach_px + 1) * (2 * kReach_px + 1);
  std::array<double, kLags> residuals{}, slopes{};

  /// @param residual, slope  of a window's pixels; NaN = none
  void add(const std::vector<float>& residual, const std::vector<float>& slope, int side) {
    double squares = 0, steep = 0;
    for (std::size_t i = 0; i < residual.size(); ++i) {
      if (std::isnan(residual[i])) continue;
      squares += static_cast<double>(residual[i]) * residual[i];
      steep += static_cast<double>(slope[i]) * slope[i];
    }
    if (!(squares > 0) || !(steep > 0)) return;
    for (int dy = 0; dy <= kReach_px; ++dy) {
      for (int dx = -kReach_px; dx <= kReach_px; ++dx) {
        double own_residuals = 0, own_slopes = 0;
        for (int y = 0; y + dy < side; ++y) {
          for (int x = std::max(0, -dx); x < std::min(side, side - dx); ++x) {
            const auto a = static_cast<std::size_t>(y * side + x),
                       b = static_cast<std::size_t>((y + dy) * side + x + dx);
            if (std::isnan(residual[a]) || std::isnan(residual[b])) continue;
            own_residuals += static_cast<double>(residual[a]) * residual[b];
            own_slopes += static_cast<double>(slope[a]) * slope[b];
          }
        }
        const auto lag = static_cast<std::size_t>(dy * (2 * kReach_px + 1) + dx + kReach_px);
        residuals[lag] += own_residuals / squares;
        slopes[lag] += own_slopes / steep;
      }
    }
  }
  void add(const NoiseLikeness& more) {
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      residuals[i] += more.residuals[i];
      slopes[i] += more.slopes[i];
    }
  }
  /// By which the deviations are larger than for independent noise.
  double sigma_factor() const {
    const double squares = residuals[kReach_px], steep = slopes[kReach_px];
    if (!(squares > 0) || !(steep > 0)) return 1;
    double sum = 0;
    for (int dy = 0; dy <= kReach_px; ++dy) {
      for (int dx = -kReach_px; dx <= kReach_px; ++dx) {
        if (dy == 0 && dx < 0) continue;  // lags and their opposites are alike
        const auto lag = static_cast<std::size_t>(dy * (2 * kReach_px + 1) + dx + kReach_px);
        sum += (dy == 0 && dx == 0 ? 1 : 2) * (residuals[lag] / squares) * (slopes[lag] / steep);
      }
    }
    return std::sqrt(std::max(1.0, sum));
  }
};

class Refiner {
 public:
  Refiner(const Image<float>& left, const Image<float>& right, const Image<float>& found_px,
          const DisparityRefinementConfig& config)
      : left_(left), right_(right), found_px_(found_px), config_(config) {
    const int r = config.radius_px;
    const float sigma = 0.6F * static_cast<float>(r) + 0.3F;
    for (int y = -r; y <= r; ++y) {
      for (int x = -r; x <= r; ++x)
        weights_.push_back(std::exp(-0.5F * static_cast<float>(x * x + y * y) / (sigma * sigma)));
    }
  }

  /// Where the window about a pixel fits best; `disparity_px` is NaN where it does not.
  RefinedWindow at(int x, int y) {
    RefinedWindow window;
    const float found = found_px_(x, y);
    if (!(found > 0) || !find_plane(x, y, found)) return window;
    float d = found;
    WindowFit fit;
    constexpr int kSteps = 4;
    for (int step = 0; step <= kSteps; ++step) {
      fit = fit_window(sums_at(x, y, d));
      if (!fit.ok) return window;
      if (step == kSteps || std::abs(fit.step_px) < 0.01F) break;
      d += std::clamp(fit.step_px, -0.5F, 0.5F);
      if (!(std::abs(d - found) <= static_cast<float>(config_.most_moved_px))) return window;
    }
    if (fit.likeness < static_cast<float>(config_.least_likeness) || !(d > 0)) return window;
    window.disparity_px = d;
    window.sigma_px = std::sqrt(fit.variance_px2);
    window.gain = fit.gain;
    window.residual = fit.residual;
    return window;
  }

  /// RMS of the disparities about a pixel from a plane through them.
  float roughness_px(int x, int y) {
    const float own = found_px_(x, y);
    return !std::isnan(own) && find_plane(x, y, own) ? rough_px_ : kNone;
  }

  /// Adds what the residuals of the window that at() has found, and its gradients, have in common
  /// with those of pixels near by.
  void add_likeness(int x, int y, const RefinedWindow& window, NoiseLikeness& sums) const {
    const int r = config_.radius_px, side = 2 * r + 1;
    std::vector<float> residual(static_cast<std::size_t>(side * side), kNone), slope = residual;
    double mean_residual = 0, mean_slope = 0;
    for (const Member& m : members_) {
      const float there = static_cast<float>(x + m.dx) - window.disparity_px -
                          per_x_ * static_cast<float>(m.dx) - per_y_ * static_cast<float>(m.dy);
      if (!(there >= 0 && there <= static_cast<float>(right_.width() - 1))) return;
      const RowSample sample = sample_row(right_.row(y + m.dy).data(), right_.width(), there);
      const auto at = static_cast<std::size_t>((m.dy + r) * side + m.dx + r);
      residual[at] = m.left.value - window.gain * sample.value;
      slope[at] = sample.slope;
      mean_residual += static_cast<double>(residual[at]) / static_cast<double>(members_.size());
      mean_slope += static_cast<double>(slope[at]) / static_cast<double>(members_.size());
    }
    for (std::size_t i = 0; i < residual.size(); ++i) {
      residual[i] -= static_cast<float>(mean_residual);
      slope[i] -= static_cast<float>(mean_slope);
    }
    sums.add(residual, slope, side);
  }

 private:
  float weight_at(int dx, int dy) const {
    const int r = config_.radius_px;
    return weights_[static_cast<std::size_t>((dy + r) * (2 * r + 1) + dx + r)];
  }

  /// Slopes of the disparities about a pixel, and which pixels lie on that plane.
  bool find_plane(int x, int y, float found) {
    const int r = config_.radius_px;
    members_.clear();
    per_x_ = per_y_ = 0;
    float slack = 1.5F * static_cast<float>(config_.same_surface_px);
    for (int round = 0; round < 2; ++round) {
      double w = 0, sx = 0, sy = 0, sd = 0, xx = 0, xy = 0, yy = 0, xd = 0, yd = 0, dd = 0;
      for (int dy = -r; dy <= r; ++dy) {
        if (y + dy < 0 || y + dy >= found_px_.height()) continue;
        const auto row = found_px_.row(y + dy);
        for (int dx = std::max(-r, -x); dx <= std::min(r, found_px_.width() - 1 - x); ++dx) {
          const float d = row[static_cast<std::size_t>(x + dx)] - found;
          const float off = d - per_x_ * static_cast<float>(dx) - per_y_ * static_cast<float>(dy);
          if (!(std::abs(off) <= slack)) continue;
          const double weight = weight_at(dx, dy);
          w += weight;
          sx += weight * dx;
          sy += weight * dy;
          sd += weight * d;
          xx += weight * dx * dx;
          xy += weight * dx * dy;
          yy += weight * dy * dy;
          xd += weight * dx * d;
          yd += weight * dy * d;
          dd += weight * d * d;
        }
      }
      if (!(w > 0)) return false;
      dd -= sd * sd / w;
      // A prior of level planes: few pixels say little of a slope.
      const double prior = 2;
      xx += prior - sx * sx / w;
      yy += prior - sy * sy / w;
      xy -= sx * sy / w;
      xd -= sx * sd / w;
      yd -= sy * sd / w;
      const double determinant = xx * yy - xy * xy;
      per_x_ = static_cast<float>((xd * yy - yd * xy) / determinant);
      per_y_ = static_cast<float>((yd * xx - xd * xy) / determinant);
      rough_px_ = static_cast<float>(std::sqrt(std::max(
          0.0, (dd - (xd * xd * yy + yd * yd * xx - 2 * xd * yd * xy) / determinant) / w)));
      per_x_ = std::clamp(per_x_, -0.8F, 0.8F);
      per_y_ = std::clamp(per_y_, -0.8F, 0.8F);
      slack = static_cast<float>(config_.same_surface_px);
    }
    for (int dy = -r; dy <= r; ++dy) {
      if (y + dy < 0 || y + dy >= found_px_.height()) continue;
      const auto row = found_px_.row(y + dy);
      for (int dx = std::max(-r, -x); dx <= std::min(r, found_px_.width() - 1 - x); ++dx) {
        const float off = row[static_cast<std::size_t>(x + dx)] - found -
                          per_x_ * static_cast<float>(dx) - per_y_ * static_cast<float>(dy);
        if (!(std::abs(off) <= slack)) continue;
        const int before = std::max(0, x + dx - 1), after = std::min(left_.width() - 1, x + dx + 1);
        const float slope =
            (left_(after, y + dy) - left_(before, y + dy)) / static_cast<float>(after - before);
        members_.push_back(
            {dx, dy, weight_at(dx, dy), {left_(x + dx, y + dy) - left_(x, y), slope}});
      }
    }
    return members_.size() >= 8;
  }

  WindowSums sums_at(int x, int y, float d) const {
    WindowSums sums;
    const int width = right_.width();
    const float base = right_(std::clamp(x - static_cast<int>(std::lround(d)), 0, width - 1), y);
    for (const Member& m : members_) {
      const float there = static_cast<float>(x + m.dx) - d - per_x_ * static_cast<float>(m.dx) -
                          per_y_ * static_cast<float>(m.dy);
      if (!(there >= 0 && there <= static_cast<float>(width - 1))) continue;
      RowSample sample = sample_row(right_.row(y + m.dy).data(), width, there);
      sample.value -= base;
      sums.add(m.weight, m.left, sample);
    }
    return sums;
  }

  struct Member {
    int dx, dy;
    float weight;
    RowSample left;
  };
  const Image<float>&left_, &right_, &found_px_;
  const DisparityRefinementConfig& config_;
  std::vector<float> weights_;
  std::vector<Member> members_;
  float per_x_ = 0, per_y_ = 0, rough_px_ = 0;
};

/// What windows evenly over the image say of the noise.
struct PairNoise {
  double sigma_factor = 1;
  float brightness = 0;  ///< of one image, median
};
PairNoise noise_of(const Image<float>& left, const Image<float>& right,
                   const Image<float>& found_px, const DisparityRefinementConfig& config) {
  constexpr int kStep_px = 12;
  const int rows = (left.height() + kStep_px - 1) / kStep_px;
  std::vector<NoiseLikeness> of_row(static_cast<std::size_t>(rows));
  std::vector<std::vector<float>> residuals(static_cast<std::size_t>(rows));
  tbb::parallel_for(0, rows, [&](int row) {
    Refiner refiner(left, right, found_px, config);
    const int y = row * kStep_px;
    for (int x = 0; x < left.width(); x += kStep_px) {
      const RefinedWindow window = refiner.at(x, y);
      if (std::isnan(window.disparity_px)) continue;
      refiner.add_likeness(x, y, window, of_row[static_cast<std::size_t>(row)]);
      // Both images' noise is in a residual.
      residuals[static_cast<std::size_t>(row)].push_back(window.residual /
                                                         std::hypot(1.0F, window.gain));
    }
  });
  NoiseLikeness sum;
  for (const NoiseLikeness& row : of_row) sum.add(row);
  std::vector<float> all;
  for (const auto& row : residuals) all.insert(all.end(), row.begin(), row.end());
  if (all.empty()) return {};
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  return {sum.sigma_factor(), *middle};
}

/// Adds what a window's plane does not have of the surface to the deviations, and leaves out what
/// is then known too badly.
void add_roughness(const Image<float>& left, const Image<float>& right,
                   const DisparityRefinementConfig& config, RefinedDisparities& refined) {
  Image<float> sigma_px(left.width(), left.height(), kNone);
  tbb::parallel_for(tbb::blocked_range<int>(0, left.height(), 8), [&](const auto& range) {
    Refiner refiner(left, right, refined.disparity_px, config);
    for (int y = range.begin(); y < range.end(); ++y) {
      for (int x = 0; x < left.width(); ++x) {
        const float rough_px = static_cast<float>(config.rough_share) * refiner.roughness_px(x, y);
        const float sum_px = std::hypot(std::hypot(refined.sigma_px(x, y), rough_px),
                                        static_cast<float>(config.sigma_floor_px));
        if (sum_px <= static_cast<float>(config.most_sigma_px)) sigma_px(x, y) = sum_px;
      }
    }
  });
  for (std::size_t i = 0; i < sigma_px.size(); ++i) {
    if (std::isnan(sigma_px.data()[i])) refined.disparity_px.data()[i] = kNone;
  }
  refined.sigma_px = std::move(sigma_px);
}

}  // namespace

RefinedDisparities refine_disparities(const Image<float>& left, const Image<float>& right,
                                      const Image<float>& found_px,
                                      const DisparityRefinementConfig& config) {
  const auto same_size = [&](const Image<float>& image) {
    return image.width() == left.width() && image.height() == left.height();
  };
  if (!same_size(right) || !same_size(found_px))
    throw std::invalid_argument("refine_disparities: images and disparities differ in size");
  RefinedDisparities refined{Image<float>(left.width(), left.height(), kNone),
                             Image<float>(left.width(), left.height(), kNone), 0};
  if (left.width() < 4) return refined;
  const PairNoise noise = noise_of(left, right, found_px, config);
  refined.noise = noise.brightness;
  const auto factor = static_cast<float>(config.noise_share * noise.sigma_factor);
  tbb::parallel_for(tbb::blocked_range<int>(0, left.height(), 8), [&](const auto& range) {
    Refiner refiner(left, right, found_px, config);
    for (int y = range.begin(); y < range.end(); ++y) {
      for (int x = 0; x < left.width(); ++x) {
        const RefinedWindow window = refiner.at(x, y);
        refined.disparity_px(x, y) = window.disparity_px;
        refined.sigma_px(x, y) = factor * window.sigma_px;
      }
    }
  });
  add_roughness(left, right, config, refined);
  return refined;
}

}  // namespace cousin
