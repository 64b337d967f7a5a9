#include "benchmarks/sensors/depth_model_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/render/ray_scene.h"

namespace cousin {
namespace {

/// Depths over which the configuration measures, in steps of a constant factor.
std::vector<double> depths(const ActiveStereoConfig& config, int steps, double shift) {
  const double nearest = 1.25 * least_depth_m(config);
  const double farthest = std::min(0.6 * config.largest_depth_m, 14 * nearest);
  std::vector<double> result;
  for (int i = 0; i < steps; ++i)
    result.push_back(nearest * std::pow(farthest / nearest, (i + shift) / (steps - 1 + 2 * shift)));
  return result;
}

/// Weights of the two knots about x.
struct KnotWeights {
  int first = 0;
  double t = 0;
};
KnotWeights knot_weights(const std::vector<double>& knots, double x) {
  const int last = static_cast<int>(knots.size()) - 2;
  int i = 0;
  while (i < last && x >= knots[static_cast<std::size_t>(i) + 1]) ++i;
  const double low = knots[static_cast<std::size_t>(i)];
  const double high = knots[static_cast<std::size_t>(i) + 1];
  return {i, std::clamp((x - low) / (high - low), 0.0, 1.0)};
}

struct Sample {
  double x, y, weight;
};

/// Values at knots by weighted least squares, with a little stiffness where samples are few.
std::vector<double> fit_curve(const std::vector<double>& knots,
                              const std::vector<Sample>& samples) {
  const auto n = static_cast<Eigen::Index>(knots.size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  for (const Sample& s : samples) {
    const KnotWeights w = knot_weights(knots, s.x);
    Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
    row(w.first) = 1 - w.t;
    row(w.first + 1) = w.t;
    a += s.weight * row * row.transpose();
    b += s.weight * s.y * row;
  }
  const double stiffness = 0.02 * a.trace() / static_cast<double>(n);
  for (Eigen::Index i = 0; i + 1 < n; ++i) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
    row(i) = -1;
    row(i + 1) = 1;
    a += stiffness * row * row.transpose();
  }
  const Eigen::VectorXd values = a.ldlt().solve(b);
  return {values.data(), values.data() + n};
}

double value_at(const std::vector<double>& knots, const std::vector<double>& values, double x) {
  const KnotWeights w = knot_weights(knots, x);
  const auto i = static_cast<std::size_t>(w.first);
  return values[i] * (1 - w.t) + values[i + 1] * w.t;
}

double rounded(double v) { return std::round(v * 1e4) / 1e4; }

void clamp_and_round(std::vector<double>& values, double low, double high) {
  for (double& v : values) v = rounded(std::clamp(v, low, high));
}

double log2_snr(const WallScores& wall, double margin_weight) {
  const double variance = wall.noise_e2 + margin_weight * wall.margin_e * wall.margin_e;
  return std::log2(std::max(wall.signal_e / std::sqrt(variance), 1e-6));
}

/// Curves over the signal-to-noise ratio, from walls that face the camera, for one weight of the
/// margin. @returns the mean square misfit: fill in 0.02, noise in a twentieth.
double fit_curves(const std::vector<WallScores>& walls, double quantisation_px,
                  DepthModelConfig& model) {
  double low = 40, high = -40;
  for (const WallScores& w : walls) {
    low = std::min(low, log2_snr(w, model.margin_weight));
    high = std::max(high, log2_snr(w, model.margin_weight));
  }
  constexpr int kKnots = 13;
  model.log2_snr.clear();
  for (int i = 0; i < kKnots; ++i)
    model.log2_snr.push_back(rounded(low + (high - low) * i / (kKnots - 1)));
  std::vector<Sample> spatial, temporal, fill;
  for (const WallScores& w : walls) {
    const double x = log2_snr(w, model.margin_weight);
    fill.push_back({x, w.fill, 1});
    if (w.fill < 0.05) continue;
    spatial.push_back({x, w.spatial_px, 1 / std::pow(w.spatial_px, 2)});
    // The model adds the step's own noise when it rounds.
    const double t =
        std::sqrt(std::max(w.temporal_px * w.temporal_px - std::pow(quantisation_px, 2) / 12, 0.0));
    temporal.push_back({x, t, 1 / std::pow(w.temporal_px + 0.01, 2)});
  }
  const auto fit = [&](const std::vector<Sample>& samples, std::vector<double>& values, double most,
                       double scale, bool rises) {
    values = fit_curve(model.log2_snr, samples);
    // More light is never worse.
    for (std::size_t i = values.size() - 1; i > 0; --i) {
      values[i - 1] =
          rises ? std::min(values[i - 1], values[i]) : std::max(values[i - 1], values[i]);
    }
    clamp_and_round(values, 0, most);
    double misfit = 0;
    for (const Sample& s : samples)
      misfit += s.weight * std::pow((value_at(model.log2_snr, values, s.x) - s.y) / scale, 2);
    return misfit / static_cast<double>(samples.size());
  };
  return fit(fill, model.fill, 1, 0.02, true) + fit(spatial, model.spatial_px, 100, 0.05, false) +
         fit(temporal, model.temporal_px, 100, 0.05, false);
}

/// The weight of the margin that makes the curves fit best.
void fit_margin(const std::vector<WallScores>& walls, double quantisation_px,
                DepthModelConfig& model) {
  DepthModelConfig best = model;
  double least = std::numeric_limits<double>::infinity();
  for (const double weight : {0.0, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5}) {
    model.margin_weight = weight;
    const double misfit = fit_curves(walls, quantisation_px, model);
    if (misfit < least) {
      least = misfit;
      best = model;
    }
  }
  model = best;
}

/// What a slope of disparity adds and takes: what the fast model without slopes lacks on tilted
/// walls.
void fit_slopes(const std::vector<ModelComparison>& walls, DepthModelConfig& model) {
  double noise = 0, noise_weight = 0, loss = 0, loss_weight = 0;
  for (const ModelComparison& w : walls) {
    const double s2 = w.full.slope * w.full.slope;
    if (w.full.fill > 0.2 && w.fast.fill > 0.2) {
      noise += (std::pow(w.full.spatial_px, 2) - std::pow(w.fast.spatial_px, 2)) * s2;
      noise_weight += s2 * s2 * s2;
    }
    if (w.fast.fill > 0.2) {
      loss += (1 - w.full.fill / w.fast.fill) * s2;
      loss_weight += s2 * s2;
    }
  }
  model.slope_noise =
      noise_weight > 0 ? rounded(std::sqrt(std::max(0.0, noise / noise_weight))) : 0;
  model.slope_loss = loss_weight > 0 ? rounded(std::max(0.0, loss / loss_weight)) : 0;
}

ObjectModel plate_model(double half_m) {
  ObjectModel model;
  model.name = "plate";
  model.mesh.vertices_m = {
      {-half_m, -half_m, 0}, {half_m, -half_m, 0}, {half_m, half_m, 0}, {-half_m, half_m, 0}};
  model.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return model;
}

}  // namespace

std::vector<WallCase> fit_walls(const ActiveStereoConfig& config) {
  std::vector<WallCase> walls;
  const double texture = config.has_projector ? 0 : 0.6;
  const std::vector<double> lights =
      config.has_projector ? std::vector<double>{0.01, 0.1, 1} : std::vector<double>{0.03, 0.3, 3};
  const std::vector<double> distances = depths(config, 6, 0);
  for (std::size_t i = 0; i < distances.size(); ++i) {
    for (const double light : lights) {
      walls.push_back({distances[i], 0, 0.5, light, texture});
      if (i >= 2) walls.push_back({distances[i], 0, 0.08, light, texture});
    }
  }
  for (const double z : depths(config, 2, 0.5)) {
    for (const double incidence : {0.5, 0.8, 1.05})
      walls.push_back({z, incidence, 0.5, config.has_projector ? lights[0] : lights[2], texture});
  }
  return walls;
}

std::vector<WallCase> test_walls(const ActiveStereoConfig& config) {
  std::vector<WallCase> walls;
  const double texture = config.has_projector ? 0 : 0.6;
  const std::vector<double> lights =
      config.has_projector ? std::vector<double>{0.03, 0.3} : std::vector<double>{0.1, 1};
  for (const double z : depths(config, 5, 0.3)) {
    for (const double light : lights) walls.push_back({z, 0, 0.3, light, texture});
  }
  for (const double z : depths(config, 2, 0.7)) {
    for (const double incidence : {0.35, 0.65, 0.95})
      walls.push_back({z, incidence, 0.3, config.has_projector ? lights[0] : lights[1], texture});
  }
  return walls;
}

DepthModelConfig fit_depth_model(const ActiveStereoConfig& config, const ActiveStereoUnit& unit,
                                 int frames, const Rng& rng,
                                 const std::function<void(int, int)>& progress) {
  DepthModelConfig model = config.model;
  const std::vector<WallCase> walls = fit_walls(config);
  std::vector<WallScores> facing;
  std::vector<WallCase> tilted;
  double bias = 0, band = 0, bands = 0, grain = 0, grains = 0;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    if (progress) progress(static_cast<int>(i), static_cast<int>(walls.size()));
    if (walls[i].incidence_rad != 0) {
      tilted.push_back(walls[i]);
      continue;
    }
    const Rng own = rng.fork(i);
    facing.push_back(score_full_model(see_wall(walls[i], config, unit, own), config, unit, frames,
                                      own.fork("full")));
    const WallScores& s = facing.back();
    if (s.fill < 0.99) continue;
    bias += s.bias_px;
    band += s.band_px - s.disparity_px;
    bands += 1;
    if (s.neighbours > 0 && s.neighbours < 1) {
      grain += 3 / (1 - s.neighbours);  // averages over squares correlate by 1 - lag / width
      grains += 1;
    }
  }
  fit_margin(facing, config.disparity_step_px, model);
  if (bands > 0) {
    model.bias_px = rounded(bias / bands);
    model.band_px = rounded(band / bands);
  }
  if (grains > 0) model.grain_px = rounded(std::clamp(grain / grains, 1.0, 65.0));

  ActiveStereoConfig without_slopes = config;
  without_slopes.model = model;
  without_slopes.model.slope_noise = without_slopes.model.slope_loss = 0;
  const auto compared = compare_models(tilted, without_slopes, unit, frames, rng.fork("tilted"));
  fit_slopes(compared, model);
  double ripple = 0;
  for (const ModelComparison& c : compared) ripple += c.full.ripple_px;
  if (!compared.empty()) model.ripple_px = rounded(ripple / static_cast<double>(compared.size()));
  const PlateEdges edges = plate_edges(config, unit, rng.fork("plate"));
  model.fatten_px = rounded(std::clamp(edges.growth_px, 0.0, 32.0));
  model.rim_px = rounded(std::clamp(edges.rim_px, 0.0, 32.0));
  return model;
}

std::vector<ModelComparison> compare_models(const std::vector<WallCase>& walls,
                                            const ActiveStereoConfig& config,
                                            const ActiveStereoUnit& unit, int frames,
                                            const Rng& rng) {
  std::vector<ModelComparison> result;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    const Rng own = rng.fork(i);
    const WallView view = see_wall(walls[i], config, unit, own);
    result.push_back({walls[i], score_full_model(view, config, unit, frames, own.fork("full")),
                      score_fast_model(view, config, unit, frames, own.fork("fast"))});
  }
  return result;
}

PlateEdges plate_edges(const ActiveStereoConfig& config, const ActiveStereoUnit& unit,
                       const Rng& rng) {
  const double near_m = 2.5 * least_depth_m(config), far_m = 1.6 * near_m;
  const double texture = config.has_projector ? 0 : 0.6;
  WallScene scene = make_wall({far_m, 0, 0.5, config.has_projector ? 0.02 : 1.0, texture});
  const double half_m = 0.25 * near_m;
  Instance plate = scene.scene.instances[0];
  plate.id = 2;
  plate.model = static_cast<int>(scene.scene.models.size());
  plate.world_from_object.translation_m.x() = near_m;
  scene.scene.models.push_back(plate_model(half_m));
  scene.scene.instances.push_back(plate);
  const RayScene rays(scene.scene);
  const InfraredPair pair = render_infrared_pair(rays, scene.scene, scene.rig_from_world, config,
                                                 unit, rng.fork("light"));
  const StereoDepth depth = sense_depth(pair, config, unit, rng.fork("sensor"));
  const Image<std::uint8_t> hidden = stereo_occlusion(pair.depth_m, config);
  const double split_m = 0.5 * (near_m + far_m);
  const double focal_baseline = unit.imager.fx_px * unit.baseline_m;
  double found = 0, truth = 0, none = 0;
  for (int y = 0; y < depth.depth.height(); ++y) {
    for (int x = 0; x < depth.depth.width(); ++x) {
      const double z = depth.depth(x, y) * config.depth_unit_m;
      const auto true_z = static_cast<double>(pair.depth_m(x, y));
      found += z > 0.8 * near_m && z < split_m ? 1 : 0;
      truth += true_z < split_m ? 1 : 0;
      const bool is_seen = hidden(x, y) == 0 && x - focal_baseline / true_z > 8;
      const bool is_near_plate =
          std::abs(std::abs(x - unit.imager.cx_px) - half_m / near_m * unit.imager.fx_px) < 12 ||
          std::abs(std::abs(y - unit.imager.cy_px) - half_m / near_m * unit.imager.fy_px) < 12;
      none += is_seen && is_near_plate && z == 0 ? 1 : 0;
    }
  }
  return {0.5 * (std::sqrt(found) - std::sqrt(truth)), none / (4 * std::sqrt(truth))};
}

}  // namespace cousin
