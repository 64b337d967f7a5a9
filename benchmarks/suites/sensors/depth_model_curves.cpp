#include "benchmarks/suites/sensors/depth_model_curves.h"

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
  double steep = 0;       ///< square of the slope, by which the fill goes
  double tilt = 0;        ///< its power 1.5, by which the noise goes
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

/// What the curves run over: of each pixel of each wall.
using Contrasts = std::vector<std::vector<double>>;
Contrasts contrasts_of(const std::vector<WallScores>& walls, const ActiveStereoConfig& config,
                       const DepthModelConfig& model) {
  Contrasts result;
  const auto reach_px = static_cast<float>(model.reach_px);
  for (const WallScores& wall : walls) {
    const MatchContrast contrast(config, wall.light, model.contrast_dots, model.contrast_spread);
    std::vector<double>& own = result.emplace_back();
    for (const WallPixel& p : wall.samples) {
      const float signal_e = signal_in_reach(p.signal_e, p.rise, reach_px);
      own.push_back(static_cast<double>(contrast(signal_e, p.ambient_e)));
    }
  }
  return result;
}

/// Its range, less its tails.
Knots knots_over(const Contrasts& contrasts) {
  std::vector<double> all;
  for (const std::vector<double>& own : contrasts) all.insert(all.end(), own.begin(), own.end());
  std::sort(all.begin(), all.end());
  if (all.empty()) return {};
  const double low = all[all.size() / 50], high = all[all.size() - 1 - all.size() / 50];
  return {low, std::max(0.01, (high - low) / static_cast<double>(kKnots - 1))};
}

Wall wall_pixels(const WallScores& wall, const std::vector<double>& contrasts, const Knots& knots,
                 double window_px) {
  Wall result;
  for (std::size_t i = 0; i < wall.samples.size(); ++i) {
    const WallPixel& p = wall.samples[i];
    Pixel pixel;
    const double at =
        std::clamp((contrasts[i] - knots.first) / knots.step, 0.0, static_cast<double>(kKnots - 1));
    pixel.knot = std::min(static_cast<Eigen::Index>(at), kKnots - 2);
    pixel.t = at - static_cast<double>(pixel.knot);
    const auto d = static_cast<double>(p.disparity_px);
    pixel.cosine = static_cast<double>(wave_share(p.slope, static_cast<float>(window_px))) *
                   std::cos(2 * std::numbers::pi * d);
    const auto slope = static_cast<double>(p.slope);
    pixel.steep = slope * slope;
    pixel.tilt = slope * std::sqrt(slope);
    result.push_back(pixel);
  }
  return result;
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
  return curve_at(p, at) + wave_at(p, at) * at.cosine - slope_of(p) * at.steep;
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

/// All curves over one contrast.
struct Fit {
  Knots knots;
  std::vector<Wall> walls;
  Eigen::VectorXd fill, spatial, temporal;
  double misfit = 0;
};

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
void fit_fill(const std::vector<WallScores>& walls, Fit& fit) {
  const auto residuals = [&](const Eigen::VectorXd& p) {
    std::vector<double> r;
    for (std::size_t i = 0; i < walls.size(); ++i)
      r.push_back((mean_fill(p, fit.walls[i]) - walls[i].fill) / 0.01);
    add_priors(p, 0.5, 1, r);
    return as_vector(r);
  };
  fit.fill = least_squares(residuals, start_at(-2, 3));
  fit.misfit += residuals(fit.fill).squaredNorm();
}

/// Spatial and temporal noise of the pixels that have a depth, in twentieths.
void fit_noise(const std::vector<WallScores>& walls, double disparity_step_px, Fit& fit) {
  constexpr double kLeastFill = 0.1;
  std::vector<std::vector<double>> weights;
  for (const Wall& wall : fit.walls) {
    std::vector<double>& own = weights.emplace_back();
    for (const Pixel& at : wall) own.push_back(normal_below(score_of(fit.fill, at)));
  }
  // The model adds the step's own noise when it rounds.
  const double step_px2 = disparity_step_px * disparity_step_px / 12;
  const auto fitted = [&](const std::function<double(const WallScores&)>& variance) {
    const auto residuals = [&](const Eigen::VectorXd& p) {
      std::vector<double> r;
      for (std::size_t i = 0; i < walls.size(); ++i) {
        if (walls[i].fill < kLeastFill) continue;
        double sum = 0, all = 1e-12;
        for (std::size_t k = 0; k < weights[i].size(); ++k) {
          sum += weights[i][k] * variance_of(p, fit.walls[i][k]);
          all += weights[i][k];
        }
        const double measured = std::max(variance(walls[i]), 1e-6);
        r.push_back(0.5 * std::log(std::max(sum / all, 1e-12) / measured) / 0.05);
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
}

Fit fit_curves(const std::vector<WallScores>& walls, const ActiveStereoConfig& config,
               const DepthModelConfig& model) {
  const double window_px = config.match.census_width_px + config.match.block_px - 1;
  const Contrasts contrasts = contrasts_of(walls, config, model);
  Fit fit;
  fit.knots = knots_over(contrasts);
  for (std::size_t i = 0; i < walls.size(); ++i)
    fit.walls.push_back(wall_pixels(walls[i], contrasts[i], fit.knots, window_px));
  fit_fill(walls, fit);
  fit_noise(walls, config.disparity_step_px, fit);
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
void fit_ripple(const std::vector<WallScores>& walls, const Fit& fit, DepthModelConfig& model) {
  std::vector<Eigen::VectorXd> rows;
  std::vector<double> values;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    const WallScores& wall = walls[i];
    if (wall.fill < 0.2 || wall.slope > 1e-3) continue;
    const Wall& pixels = fit.walls[i];
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
  Fit best;
  best.misfit = std::numeric_limits<double>::infinity();
  DepthModelConfig tried = model;
  for (const double dots : {0.0, 0.5, 1.0}) {
    for (const double spread : {1.0, 1.5, 2.0, 2.5, 3.0}) {
      for (const double reach_px : {0.0, 8.0, 16.0, 24.0, 32.0}) {
        tried.contrast_dots = dots;
        tried.contrast_spread = spread;
        tried.reach_px = reach_px;
        Fit next = fit_curves(walls, config, tried);
        if (!(next.misfit < best.misfit)) continue;
        best = std::move(next);
        model = tried;
      }
    }
  }
  model.contrast = best.knots.list();
  model.fill_score = part(best.fill, 0, false, -10, 10);
  model.fill_wave = part(best.fill, kKnots, false, -10, 10);
  model.slope_fill = rounded(std::clamp(slope_of(best.fill), 0.0, 1e4));
  model.spatial_px = part(best.spatial, 0, true, 0, 100);
  model.spatial_wave = part(best.spatial, kKnots, false, -0.9, 0.9);
  model.slope_spatial = rounded(std::abs(slope_of(best.spatial)));
  model.temporal_px = part(best.temporal, 0, true, 0, 100);
  model.temporal_wave = part(best.temporal, kKnots, false, -0.9, 0.9);
  model.slope_temporal = rounded(std::abs(slope_of(best.temporal)));
  fit_ripple(walls, best, model);
}

}  // namespace cousin
