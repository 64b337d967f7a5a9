#include "benchmarks/suites/sensors/depth_wall.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim/render/ray_scene.h"

namespace cousin {
namespace {

/// Square of two triangles about the origin in z = 0, facing +z.
ObjectModel square(double half_m) {
  ObjectModel model;
  model.name = "wall";
  model.mesh.vertices_m = {
      {-half_m, -half_m, 0}, {half_m, -half_m, 0}, {half_m, half_m, 0}, {-half_m, half_m, 0}};
  model.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return model;
}

struct Sums {
  double n = 0, sum = 0, squares = 0;
  void add(double v) {
    n += 1;
    sum += v;
    squares += v * v;
  }
  double mean() const { return sum / n; }
  double sigma() const { return std::sqrt(std::max(0.0, squares / n - mean() * mean())); }
};

/// Gathers the errors of several frames of one wall.
class WallStatistics {
 public:
  WallStatistics(const WallView& view, const ActiveStereoConfig& config,
                 const ActiveStereoUnit& unit)
      : depth_m_(view.pair.depth_m),
        unit_m_(config.depth_unit_m),
        focal_baseline_(unit.imager.fx_px * unit.baseline_m),
        pixels_(depth_m_.size()) {
    light_ = pattern_light(view.inputs, config);
    for_pixels([&](int x, int y, double truth_px) {
      truth_.add(truth_px);
      const double right = focal_baseline_ / static_cast<double>(depth_m_(x + 1, y));
      const double below = focal_baseline_ / static_cast<double>(depth_m_(x, y + 1));
      slope_.add(std::hypot(right - truth_px, below - truth_px));
      if (x % kSampled_px != 0 || y % kSampled_px != 0) return;
      samples_.push_back({light_.signal_e(x, y), light_.ambient_e(x, y), light_.rise(x, y),
                          static_cast<float>(truth_px),
                          static_cast<float>(std::hypot(right - truth_px, below - truth_px))});
    });
    light_.signal_e = light_.ambient_e = light_.rise = {};
  }

  void add(const Image<float>& disparity_px, const Image<std::uint16_t>& depth) {
    for_pixels([&](int x, int y, double truth_px) {
      ++asked_;
      if (depth(x, y) == 0) return;
      ++found_;
      const double error_px = static_cast<double>(disparity_px(x, y)) - truth_px;
      if (std::abs(error_px) > 1) {
        ++wrong_;
        return;
      }
      errors_.add(error_px);
      depth_errors_.add(depth(x, y) * unit_m_ - static_cast<double>(depth_m_(x, y)));
      pixels_[at(x, y)].add(error_px);
      const double wave = std::sin(2 * std::numbers::pi * truth_px);
      wave_.add(wave);
      wave_errors_ += wave * error_px;
    });
    for (int y = depth.height() / 4; y < 3 * depth.height() / 4; ++y) {
      int x = 0;
      while (x < depth.width() && depth(x, y) == 0) ++x;
      band_.add(x);
    }
  }

  WallScores scores() const {
    WallScores s;
    s.pixels = static_cast<std::int64_t>(truth_.n);
    s.fill = asked_ > 0 ? found_ / asked_ : 0;
    s.wrong = found_ > 0 ? wrong_ / found_ : 0;
    s.band_px = band_.mean();
    s.samples = samples_;
    s.light = light_;
    s.slope = slope_.mean();
    s.disparity_px = truth_.mean();
    if (errors_.n < 2) return s;
    s.bias_px = errors_.mean();
    s.sigma_px = errors_.sigma();
    s.sigma_m = depth_errors_.sigma();
    const double wave_variance = wave_.squares - wave_.n * wave_.mean() * wave_.mean();
    if (wave_variance > 0.1 * wave_.n)
      s.ripple_px = (wave_errors_ - wave_.sum * errors_.mean()) / wave_variance;
    Sums means, variances, beside;
    for_pixels([&](int x, int y, double) {
      const Sums& p = pixels_[at(x, y)];
      if (p.n < 1) return;
      means.add(p.mean());
      if (p.n >= 2) variances.add(p.sigma() * p.sigma() * p.n / (p.n - 1));
      const Sums& q = pixels_[at(x + 3, y)];
      if (q.n >= 1) beside.add((p.mean() - s.bias_px) * (q.mean() - s.bias_px));
    });
    // The mean over n frames keeps a share 1/n of the temporal variance.
    double left = 0;
    if (variances.n > 0) {
      s.temporal_px = std::sqrt(variances.mean());
      left = variances.mean() * means.n / errors_.n;
    }
    s.spatial_px = std::sqrt(std::max(0.0, means.sigma() * means.sigma() - left));
    if (beside.n > 0 && s.spatial_px > 0)
      s.neighbours = beside.mean() / (means.sigma() * means.sigma());
    return s;
  }

 private:
  static constexpr int kSampled_px = 16;
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(depth_m_.width()) +
           static_cast<std::size_t>(x);
  }
  /// Pixels of the middle half that the right imager sees, with their true disparity.
  template <class Function>
  void for_pixels(const Function& function) const {
    const int width = depth_m_.width(), height = depth_m_.height();
    for (int y = height / 4; y < 3 * height / 4; ++y) {
      for (int x = width / 4; x < 3 * width / 4; ++x) {
        const double truth_px = focal_baseline_ / static_cast<double>(depth_m_(x, y));
        if (x - truth_px >= 8) function(x, y, truth_px);
      }
    }
  }

  const Image<float>& depth_m_;
  double unit_m_, focal_baseline_;
  std::vector<Sums> pixels_;
  Sums errors_, depth_errors_, truth_, slope_, band_, wave_;
  double wave_errors_ = 0;
  std::vector<WallPixel> samples_;
  PatternLight light_;
  double asked_ = 0, found_ = 0, wrong_ = 0;
};

}  // namespace

double at_fraction_m(const ActiveStereoConfig& config, double z_m, double fraction) {
  const double focal_baseline = depth_camera(config).fx_px * config.baseline_m;
  return focal_baseline / (std::floor(focal_baseline / z_m) + fraction);
}

WallScene make_wall(const WallCase& wall) {
  WallScene out;
  Scene& scene = out.scene;
  scene.name = "wall";
  Material material;
  material.name = "wall";
  material.infrared_albedo = static_cast<float>(wall.albedo);
  material.ior = 1;
  if (wall.texture > 0) {
    NoiseTexture noise;
    const auto dark = static_cast<float>(0.5 * (1 - wall.texture));
    noise.other_albedo = {dark, dark, dark};
    noise.scale_m = 0.006 * wall.distance_m;  // some pixels
    noise.octaves = 3;
    material.noise = noise;
  }
  scene.models.push_back(square(6 * std::max(wall.distance_m, 0.1)));
  scene.materials.push_back(material);
  Instance instance;
  instance.id = 1;
  instance.name = "wall";
  // Faces -x, then turns about the vertical.
  instance.world_from_object.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(wall.incidence_rad, Eigen::Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(-0.5 * std::numbers::pi, Eigen::Vector3d::UnitY()));
  instance.world_from_object.translation_m = {wall.distance_m, 0, 0};
  scene.instances.push_back(instance);
  const auto radiance = static_cast<float>(wall.light / std::numbers::pi);
  const Rgbf even{radiance, radiance, radiance};
  scene.lights.emplace_back(Sky{even, even, even});
  out.rig_from_world = look_at({0, 0, 0}, {1, 0, 0});
  return out;
}

WallView see_wall(const WallCase& wall, const ActiveStereoConfig& config,
                  const ActiveStereoUnit& unit, const Rng& rng) {
  const WallScene scene = make_wall(wall);
  const RayScene rays(scene.scene);
  WallView view{wall,
                render_infrared_pair(rays, scene.scene, scene.rig_from_world, config, unit,
                                     rng.fork("light")),
                depth_model_inputs(rays, scene.scene, scene.rig_from_world, config, unit,
                                   rng.fork("inputs"))};
  view.inputs.texture = wall.texture / std::sqrt(12.0);
  return view;
}

WallScores score_full_model(const WallView& view, const ActiveStereoConfig& config,
                            const ActiveStereoUnit& unit, int frames, const Rng& rng) {
  WallStatistics statistics(view, config, unit);
  for (int k = 0; k < frames; ++k) {
    const StereoDepth depth =
        sense_depth(view.pair, config, unit, rng.fork(static_cast<std::uint64_t>(k)));
    statistics.add(depth.disparity_px, depth.depth);
  }
  return statistics.scores();
}

WallScores score_fast_model(const WallView& view, const ActiveStereoConfig& config,
                            const ActiveStereoUnit& unit, int frames, const Rng& rng, int scenes) {
  WallScores mean;
  double errors = 0, variance_px2 = 0, variance_m2 = 0, fill = 0;
  for (int i = 0; i < scenes; ++i) {
    const Rng own = scenes == 1 ? rng : rng.fork(static_cast<std::uint64_t>(i));
    WallStatistics statistics(view, config, unit);
    for (int k = 0; k < frames; ++k) {
      const ModelDepth depth = model_depth(view.inputs, config, own.fork("fixed"),
                                           own.fork("frame").fork(static_cast<std::uint64_t>(k)));
      statistics.add(depth.disparity_px, depth.depth);
    }
    mean = statistics.scores();
    fill += mean.fill / scenes;
    errors += mean.fill;
    variance_px2 += mean.fill * mean.sigma_px * mean.sigma_px;
    variance_m2 += mean.fill * mean.sigma_m * mean.sigma_m;
  }
  mean.fill = fill;
  if (errors > 0) {
    mean.sigma_px = std::sqrt(variance_px2 / errors);
    mean.sigma_m = std::sqrt(variance_m2 / errors);
  }
  return mean;
}

}  // namespace cousin
