#include "benchmarks/suites/sensors/moving_edge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sim/render/ray_scene.h"
#include "sim/render/truth_pass.h"
#include "sim/sensors/optics.h"

namespace cousin {
namespace {

constexpr double kDistance_m = 1.0;
constexpr double kTrail_px = 12;  ///< how far the edge moves in the longer of readout and exposure

/// A wall in z = 0 that fills the view; the edge is its line x = 0.
Scene wall() {
  Scene scene;
  ObjectModel model;
  model.name = "wall";
  model.mesh.vertices_m = {{-5, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-5, 5, 0}};
  model.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  scene.models.push_back(std::move(model));
  scene.materials.emplace_back();
  Instance instance;
  instance.id = 1;
  instance.name = "wall";
  scene.instances.push_back(instance);
  return scene;
}

/// Column at which each row sees x = 0, between pixels by the line through them.
std::vector<double> edge_columns(const RayScene& rays, const Scene& scene, const TrueView& view) {
  const TruthImages truth = render_truth(rays, scene, view, {.position = true});
  std::vector<double> columns;
  for (int y = 0; y < truth.position_m.height(); ++y) {
    double column = std::numeric_limits<double>::quiet_NaN();
    for (int x = 0; x + 1 < truth.position_m.width(); ++x) {
      const double a = static_cast<double>(truth.position_m(x, y).x());
      const double b = static_cast<double>(truth.position_m(x + 1, y).x());
      if ((a < 0) != (b < 0)) column = x + a / (a - b);
    }
    columns.push_back(column);
  }
  return columns;
}

double slope(const std::vector<double>& values) {
  const double middle = 0.5 * (static_cast<double>(values.size()) - 1);
  double sxy = 0, sxx = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double x = static_cast<double>(i) - middle;
    sxy += x * values[i];
    sxx += x * x;
  }
  return sxy / sxx;
}

/// A body that moves sideways at `speed_m_per_s` for the `span_s` that a scene's motion lasts.
View sideways(double speed_m_per_s, double span_s) {
  View view;
  view.rig_from_world = look_at({0, 0, kDistance_m}, {0, 0, 0}, Eigen::Vector3d::UnitY());
  view.rig_from_world_end = view.rig_from_world;
  view.rig_from_world_end.translation_m.x() += speed_m_per_s * span_s;
  return view;
}

}  // namespace

RigConfig small_rig(const RigConfig& config) {
  RigConfig small = config;
  small.sync_error_s = small.hand_speed_m_per_s = small.hand_rate_rad_per_s = 0;
  for (RigSensor& sensor : small.sensors) {
    CameraSensorConfig& camera = sensor.camera;
    camera.height_px = static_cast<int>(std::lround(640.0 * camera.height_px / camera.width_px));
    camera.width_px = 640;
    camera.lens.model = LensModel::pinhole;
    camera.lens.distortion.clear();
    camera.lens.spline = {};
    camera.lens.autofocus = false;
    sensor.centre_in_rig_m = sensor.rig_from_sensor_rad = {0, 0, 0};
    sensor.trigger_delay_s = 0;
  }
  return small;
}

MovingEdge measure_moving_edge(const RigConfig& rig, std::size_t sensor) {
  RigConfig small = small_rig(rig);
  const RigUnit unit = make_rig(small, Rng(1));
  const Camera camera = unit.sensors.at(sensor).lens.at_infinity;
  RigSensor& moved = small.sensors.at(sensor);
  const double readout_s = moved.camera.photosites.readout_s;
  const double exposure_s = moved.camera.photosites.exposure_s;
  double span_s = 0;
  for (const RigSensor& s : small.sensors) {
    span_s = std::max(span_s, s.camera.photosites.readout_s);
  }
  const double speed_m_per_s =
      kTrail_px * kDistance_m / (camera.fx_px * std::max({readout_s, exposure_s, 1e-6}));
  const double px_per_s = camera.fx_px * speed_m_per_s / kDistance_m;

  Scene scene = wall();
  scene.views = {sideways(speed_m_per_s, span_s)};
  const RayScene rays(scene);
  const auto columns_at = [&](double delay_s) {
    moved.trigger_delay_s = delay_s;
    return edge_columns(rays, scene, true_views(small, unit, scene, 0, Rng(2))[sensor]);
  };

  MovingEdge result;
  const std::vector<double> columns = columns_at(0);
  result.skew_px = std::abs(slope(columns)) * (static_cast<double>(columns.size()) - 1);
  result.expected_skew_px = px_per_s * readout_s;
  // The trail is uniform: its standard deviation is its length over sqrt(12), at n evenly spread
  // times sqrt((n + 1) / (n - 1)) of that.
  constexpr int kTimes = 65;
  const std::size_t middle = columns.size() / 2;
  double sum = 0, squares = 0;
  for (int i = 0; i < kTimes; ++i) {
    const double column = columns_at(exposure_s * (i / (kTimes - 1.0) - 0.5))[middle];
    sum += column / kTimes;
    squares += column * column / kTimes;
  }
  const double variance = squares - sum * sum;
  result.blur_px = std::sqrt(12 * variance * (kTimes - 1.0) / (kTimes + 1.0));
  result.expected_blur_px = span_s > 0 ? px_per_s * exposure_s : 0;
  return result;
}

LateralColour measure_lateral_colour(const CameraSensorConfig& config) {
  CameraSensorConfig small = config;
  small.height_px = static_cast<int>(std::lround(640.0 * config.height_px / config.width_px));
  small.width_px = 640;
  small.lens.model = LensModel::pinhole;
  small.lens.distortion.clear();
  small.lens.spline = {};
  const Camera camera = nominal_camera(small);
  Optics optics = config.lens.optics;
  optics.vignetting_a = optics.vignetting_b = optics.vignetting_c = 0;  // would move centroids too
  constexpr int kStep = 40, kReach = 14;
  constexpr double kSigma_px = 2.5;
  Image<Rgbf> spots(small.width_px, small.height_px);
  for (int y = 0; y < spots.height(); ++y) {
    for (int x = 0; x < spots.width(); ++x) {
      const double dx = (x + kStep / 2) % kStep - kStep / 2,
                   dy = (y + kStep / 2) % kStep - kStep / 2;
      const auto v =
          static_cast<float>(std::exp(-0.5 * (dx * dx + dy * dy) / (kSigma_px * kSigma_px)));
      spots(x, y) = {v, v, v};
    }
  }
  const Image<Rgbf> seen = shade_and_blur_rows(spots, optics, camera, gaussian_weights(0), "spots");
  const double half_diagonal2 = 0.25 * (std::pow(spots.width(), 2) + std::pow(spots.height(), 2));
  LateralColour result;
  for (int cy = kStep; cy + kStep < spots.height(); cy += kStep) {
    for (int cx = kStep; cx + kStep < spots.width(); cx += kStep) {
      Eigen::Vector2d red = Eigen::Vector2d::Zero(), blue = red;
      double red_sum = 0, blue_sum = 0;
      for (int y = cy - kReach; y <= cy + kReach; ++y) {
        for (int x = cx - kReach; x <= cx + kReach; ++x) {
          const Eigen::Vector2d at(x, y);
          red += static_cast<double>(seen(x, y).r) * at;
          blue += static_cast<double>(seen(x, y).b) * at;
          red_sum += static_cast<double>(seen(x, y).r);
          blue_sum += static_cast<double>(seen(x, y).b);
        }
      }
      const Eigen::Vector2d centre(camera.cx_px, camera.cy_px);
      const Eigen::Vector2d from = Eigen::Vector2d(cx, cy) - centre;
      const auto lands = [&](const RadialColour& map) {
        return Eigen::Vector2d(
            centre + from * (map.scale + map.cubic * from.squaredNorm() / half_diagonal2));
      };
      for (const auto& [centroid, map] :
           {std::pair{Eigen::Vector2d(red / red_sum), optics.red},
            std::pair{Eigen::Vector2d(blue / blue_sum), optics.blue}}) {
        result.error_px = std::max(result.error_px, (centroid - lands(map)).norm());
        result.displacement_px =
            std::max(result.displacement_px, (lands(map) - centre - from).norm());
      }
    }
  }
  return result;
}

}  // namespace cousin
