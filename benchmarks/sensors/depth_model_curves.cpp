#include "benchmarks/sensors/depth_model_curves.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "sim/sensors/match_contrast.h"

namespace cousin {
namespace {

constexpr Eigen::Index kKnots = 10;

double normal_below(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }
double rounded(double v) { return std::round(v * 1e4) / 1e4; }

/// A sampled pixel as the curves see it.
struct Pixel {
  Eigen::Index knot = 0;  ///< the one below
  double t = 0;           ///< between it and the next
  double cosine = 0;      ///< cos(2 pi d), times what the window leaves of it
  double tilt = 0;        ///< power of the slope
  double weight = 1;
};
using Wall = std::vector<Pixel>;

struct Knots {
  double first = 0, step = 1;
  std::vector<double> list() const {
    std::vector<double> result;
    for (Eigen::Index i = 0; i < kKnots; ++i)
      result.push_back(rounded(first + static_cast<double>(i) * step));
    return result;
  }
};

/// What the curves run over, of a pixel: -infinity where there is no light.
using Abscissa = std::function<double(const WallPixel&)>;
struct Walls {
  std::vector<Abscissa> abscissas;  ///< one a wall
  double tilt_power = 2;            ///< of the slope
};

/// Its range, less its tails.
Knots knots_over(const std::vector<WallScores>& walls, const Walls& by) {
  std::vector<double> all;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    for (const WallPixel& p : walls[i].samples) {
      const double x = by.abscissas[i](p);
      if (std::isfinite(x)) all.push_back(x);
    }
  }
  std::sort(all.begin(), all.end());
  if (all.empty()) return {};
  const double low = all[all.size() / 50], high = all[all.size() - 1 - all.size() / 50];
  return {low, std::max(0.01, (high - low) / static_cast<double>(kKnots - 1))};
}

Wall wall_pixels(const WallScores& wall, const Abscissa& abscissa, double tilt_power,
                 const Knots& knots, double window_px) {
  Wall result;
  for (const WallPixel& p : wall.samples) {
    const double x = abscissa(p);
    Pixel pixel;
    const double at =
        std::clamp((x - knots.first) / knots.step, 0.0, static_cast<double>(kKnots - 1));
    pixel.knot = std::min(static_cast<Eigen::Index>(at), kKnots - 2);
    pixel.t = at - static_cast<double>(pixel.knot);
    const auto d = static_cast<double>(p.disparity_px);
    pixel.cosine = static_cast<double>(wave_share(p.slope, static_cast<float>(window_px))) *
                   std::cos(2 * std::numbers::pi * d);
    pixel.tilt = std::pow(static_cast<double>(p.slope), tilt_power);
    result.push_back(pixel);
  }
  return result;
}

Walls by_noise(const std::vector<WallScores>& walls, const PatternNoise& noise) {
  Walls by{{}, 1.5};
  for (const WallScores& wall : walls) {
    by.abscissas.emplace_back([&wall, noise](const WallPixel& p) {
      return static_cast<double>(
          log2_pattern_snr(p.signal_e, p.dots_e, p.ambient_e, wall.light, noise));
    });
  }
  return by;
}

Walls by_contrast(const std::vector<WallScores>& walls, const ActiveStereoConfig& config,
                  double dots, double spread) {
  Walls by;
  for (const WallScores& wall : walls) {
    by.abscissas.emplace_back(
        [contrast = MatchContrast(config, wall.light, dots, spread)](const WallPixel& p) {
          return static_cast<double>(contrast(p.signal_e, p.ambient_e));
        });
  }
  return by;
}

/// Parameters: a curve, the wave on it, and what a slope does.
double curve_at(const Eigen::VectorXd& p, const Pixel& at) {
  return p[at.knot] * (1 - at.t) + p[at.knot + 1] * at.t;
}
double wave_at(const Eigen::VectorXd& p, const Pixel& at) {
  return p[kKnots + at.knot] * (1 - at.t) + p[kKnots + at.knot + 1] * at.t;
}
double slope_of(const Eigen::VectorXd& p) { return p[2 * kKnots]; }

double score_of(const Eigen::VectorXd& p, const Pixel& at) {
  return curve_at(p, at) + wave_at(p, at) * at.cosine - slope_of(p) * at.tilt;
}
/// Logarithms are fitted, so that spreads stay positive.
double variance_of(const Eigen::VectorXd& p, const Pixel& at) {
  const double flat = std::exp(curve_at(p, at)) * (1 + wave_at(p, at) * at.cosine);
  const double tilted = slope_of(p) * at.tilt;
  return flat * flat + tilted * tilted;
}

using Residuals = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;

/// @returns the parameters of the least sum of squares that is found from `start`.
Eigen::VectorXd least_squares(const Residuals& residuals, Eigen::VectorXd start) {
  double damping = 1e-2;
  Eigen::VectorXd r = residuals(start);
  for (int step = 0; step < 60; ++step) {
    Eigen::MatrixXd jacobian(r.size(), start.size());
    for (Eigen::Index i = 0; i < start.size(); ++i) {
      constexpr double kStep = 1e-5;
      Eigen::VectorXd moved = start;
      moved[i] += kStep;
      jacobian.col(i) = (residuals(moved) - r) / kStep;
    }
    const Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
    const Eigen::VectorXd gradient = jacobian.transpose() * r;
    const double floor = 1e-6 * normal.diagonal().maxCoeff();
    bool is_better = false;
    for (int attempt = 0; attempt < 8 && !is_better; ++attempt) {
      Eigen::MatrixXd damped = normal;
      damped.diagonal() += damping * (normal.diagonal().array() + floor).matrix();
      const Eigen::VectorXd next = start - damped.ldlt().solve(gradient);
      const Eigen::VectorXd next_r = residuals(next);
      is_better = next_r.squaredNorm() < r.squaredNorm();
      damping *= is_better ? 0.3 : 5;
      if (!is_better) continue;
      const double gain = r.squaredNorm() - next_r.squaredNorm();
      start = next;
      r = next_r;
      if (gain < 1e-6 * r.squaredNorm()) return start;
    }
    if (!is_better) break;
  }
  return start;
}

/// Second differences of curve and wave, and the wave itself, weakly.
void add_priors(const Eigen::VectorXd& p, double curve, double wave, std::vector<double>& out) {
  for (Eigen::Index i = 0; i + 2 < kKnots; ++i) {
    out.push_back(curve * (p[i] - 2 * p[i + 1] + p[i + 2]));
    out.push_back(wave * (p[kKnots + i] - 2 * p[kKnots + i + 1] + p[kKnots + i + 2]));
  }
  for (Eigen::Index i = 0; i < kKnots; ++i) out.push_back(p[kKnots + i]);
}

Eigen::VectorXd as_vector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

/// What is known of a fit, to choose the noise's parts by.
struct Fit {
  Walls by;
  Knots knots;
  Eigen::VectorXd fill, spatial, temporal;
  double misfit = std::numeric_limits<double>::infinity();
};

std::vector<Wall> all_pixels(const std::vector<WallScores>& walls, const Fit& fit,
                             double window_px) {
  std::vector<Wall> result;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    result.push_back(
        wall_pixels(walls[i], fit.by.abscissas[i], fit.by.tilt_power, fit.knots, window_px));
  }
  return result;
}

Eigen::VectorXd start_at(double low, double high) {
  Eigen::VectorXd p = Eigen::VectorXd::Zero(2 * kKnots + 1);
  p[2 * kKnots] = 1;
  for (Eigen::Index i = 0; i < kKnots; ++i)
    p[i] = low + (high - low) * static_cast<double>(i) / static_cast<double>(kKnots - 1);
  return p;
}

double mean_fill(const Eigen::VectorXd& p, const Wall& wall) {
  double sum = 0;
  for (const Pixel& at : wall) sum += normal_below(score_of(p, at));
  return wall.empty() ? 0 : sum / static_cast<double>(wall.size());
}

/// In hundredths: what the fills of single walls are known to.
Fit fit_fill(const std::vector<WallScores>& walls, const Walls& by, double window_px) {
  Fit fit{by, knots_over(walls, by), {}, {}, {}};
  const std::vector<Wall> pixels = all_pixels(walls, fit, window_px);
  const auto residuals = [&](const Eigen::VectorXd& p) {
    std::vector<double> r;
    for (std::size_t i = 0; i < walls.size(); ++i)
      r.push_back((mean_fill(p, pixels[i]) - walls[i].fill) / 0.01);
    add_priors(p, 0.5, 1, r);
    return as_vector(r);
  };
  fit.fill = least_squares(residuals, start_at(-2, 3));
  fit.misfit = residuals(fit.fill).squaredNorm();
  return fit;
}

/// Spatial and temporal noise of the pixels that have a depth, in twentieths.
Fit fit_noise(const std::vector<WallScores>& walls, const Walls& by, double disparity_step_px,
              double window_px, const Fit& fill) {
  constexpr double kLeastFill = 0.1;
  Fit fit{by, knots_over(walls, by), {}, {}, {}, 0};
  std::vector<Wall> pixels = all_pixels(walls, fit, window_px);
  const std::vector<Wall> filled = all_pixels(walls, fill, window_px);
  for (std::size_t i = 0; i < walls.size(); ++i) {
    for (std::size_t k = 0; k < pixels[i].size(); ++k)
      pixels[i][k].weight = normal_below(score_of(fill.fill, filled[i][k]));
  }
  // The model adds the step's own noise when it rounds.
  const double step_px2 = disparity_step_px * disparity_step_px / 12;
  const auto fitted = [&](const std::function<double(const WallScores&)>& variance) {
    const auto residuals = [&](const Eigen::VectorXd& p) {
      std::vector<double> r;
      for (std::size_t i = 0; i < walls.size(); ++i) {
        if (walls[i].fill < kLeastFill) continue;
        double sum = 0, weights = 1e-12;
        for (const Pixel& at : pixels[i]) {
          sum += at.weight * variance_of(p, at);
          weights += at.weight;
        }
        const double measured = std::max(variance(walls[i]), 1e-6);
        r.push_back(0.5 * std::log(std::max(sum / weights, 1e-12) / measured) / 0.05);
      }
      add_priors(p, 2, 5, r);
      return as_vector(r);
    };
    const Eigen::VectorXd p = least_squares(residuals, start_at(std::log(0.2), std::log(0.05)));
    fit.misfit += residuals(p).squaredNorm();
    return p;
  };
  fit.spatial = fitted([](const WallScores& w) { return w.spatial_px * w.spatial_px; });
  fit.temporal =
      fitted([&](const WallScores& w) { return w.temporal_px * w.temporal_px - step_px2; });
  return fit;
}

std::vector<double> part(const Eigen::VectorXd& p, Eigen::Index first, bool is_log, double low,
                         double high) {
  std::vector<double> values;
  for (Eigen::Index i = first; i < first + kKnots; ++i)
    values.push_back(rounded(std::clamp(is_log ? std::exp(p[i]) : p[i], low, high)));
  return values;
}

/// Bias = mean + A sin(2 pi d), A a curve, by linear least squares over the walls that face the
/// camera.
void fit_ripple(const std::vector<WallScores>& walls, const Fit& noise, double window_px,
                DepthModelConfig& model) {
  std::vector<Eigen::VectorXd> rows;
  std::vector<double> values;
  const std::vector<Wall> all = all_pixels(walls, noise, window_px);
  for (std::size_t i = 0; i < walls.size(); ++i) {
    const WallScores& wall = walls[i];
    if (wall.fill < 0.2 || wall.slope > 1e-3) continue;
    const Wall& pixels = all[i];
    const double weight = 0.01 / std::max(wall.sigma_px, 0.01);
    Eigen::VectorXd row = Eigen::VectorXd::Zero(kKnots + 1);
    const double sine = std::sin(2 * std::numbers::pi * wall.disparity_px);
    for (const Pixel& at : pixels) {
      row[at.knot] += sine * (1 - at.t) / static_cast<double>(pixels.size());
      row[at.knot + 1] += sine * at.t / static_cast<double>(pixels.size());
    }
    row[kKnots] = 1;
    rows.push_back(weight * row);
    values.push_back(weight * wall.bias_px);
  }
  for (Eigen::Index i = 0; i + 1 < kKnots; ++i) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(kKnots + 1);
    row[i] = -0.1;
    row[i + 1] = 0.1;
    rows.push_back(row);
    values.push_back(0);
  }
  Eigen::MatrixXd a(static_cast<Eigen::Index>(rows.size()), kKnots + 1);
  for (std::size_t i = 0; i < rows.size(); ++i)
    a.row(static_cast<Eigen::Index>(i)) = rows[i].transpose();
  const Eigen::VectorXd p =
      (a.transpose() * a + 1e-9 * Eigen::MatrixXd::Identity(kKnots + 1, kKnots + 1))
          .ldlt()
          .solve(a.transpose() * as_vector(values));
  model.ripple_px = part(p, 0, false, -1, 1);
  model.bias_px = rounded(p[kKnots]);
}

}  // namespace

void fit_depth_curves(const std::vector<WallScores>& walls, const ActiveStereoConfig& config,
                      DepthModelConfig& model) {
  if (walls.size() < 8)
    throw std::invalid_argument("depth model: " + std::to_string(walls.size()) +
                                " walls are too few to fit; at least 8");
  const double window_px = config.match.census_width_px + config.match.block_px - 1;
  Fit fill, noise;
  for (const double dots : {0.0, 0.5, 1.0}) {
    for (const double spread : {1.0, 1.5, 2.0, 2.5, 3.0}) {
      const Fit next = fit_fill(walls, by_contrast(walls, config, dots, spread), window_px);
      if (!(next.misfit < fill.misfit)) continue;
      fill = next;
      model.fill_dots = dots;
      model.fill_spread = spread;
    }
  }
  for (const double dots : {0.0, 0.25, 0.5, 1.0}) {
    for (const double margin : {0.0, 0.02, 0.05, 0.1, 0.2}) {
      const Fit next = fit_noise(walls, by_noise(walls, {dots, margin}), config.disparity_step_px,
                                 window_px, fill);
      if (!(next.misfit < noise.misfit)) continue;
      noise = next;
      model.noise_from = {dots, margin};
    }
  }
  model.contrast = fill.knots.list();
  model.fill_score = part(fill.fill, 0, false, -10, 10);
  model.fill_wave = part(fill.fill, kKnots, false, -10, 10);
  model.slope_fill = rounded(std::clamp(slope_of(fill.fill), 0.0, 1e4));
  model.log2_snr = noise.knots.list();
  model.spatial_px = part(noise.spatial, 0, true, 0, 100);
  model.spatial_wave = part(noise.spatial, kKnots, false, -0.9, 0.9);
  model.slope_spatial = rounded(std::abs(slope_of(noise.spatial)));
  model.temporal_px = part(noise.temporal, 0, true, 0, 100);
  model.temporal_wave = part(noise.temporal, kKnots, false, -0.9, 0.9);
  model.slope_temporal = rounded(std::abs(slope_of(noise.temporal)));
  fit_ripple(walls, noise, window_px, model);
}

}  // namespace cousin
