#include "tests/calibration/boards/synthetic_board.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace cousin::synthetic {
namespace {

constexpr int kRays = 55;  // per pixel
using Color = Eigen::Vector3f;

struct LocalEllipsoid {
  Eigen::Matrix3d unit_from_world;  ///< to the unit sphere
  Eigen::Vector3d centre;
  double reach_m;
};

/// Distance along the ray to the ellipsoid, or infinity.
double hit(const LocalEllipsoid& e, const Eigen::Vector3d& origin,
           const Eigen::Vector3d& direction) {
  const Eigen::Vector3d o = e.unit_from_world * (origin - e.centre),
                        d = e.unit_from_world * direction;
  const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - 1;
  const double discriminant = b * b - a * c;
  return discriminant < 0 ? std::numeric_limits<double>::infinity()
                          : (-b - std::sqrt(discriminant)) / a;
}

Color shade(const SeedBoard& board, const std::vector<LocalEllipsoid>& ellipsoids,
            const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d light = Eigen::Vector3d(0.3, 0.2, 0.93).normalized();
  const double to_plane = -origin.z() / direction.z();
  const Eigen::Vector3d ground = origin + to_plane * direction;
  double nearest = to_plane;
  const LocalEllipsoid* seen = nullptr;
  for (const LocalEllipsoid& e : ellipsoids) {
    if (std::abs(ground.x() - e.centre.x()) > e.reach_m ||
        std::abs(ground.y() - e.centre.y()) > e.reach_m)
      continue;
    const double t = hit(e, origin, direction);
    if (t > 0 && t < nearest) nearest = t, seen = &e;
  }
  if (seen != nullptr) {
    const Eigen::Vector3d p = origin + nearest * direction;
    const Eigen::Vector3d normal =
        (seen->unit_from_world.transpose() * (seen->unit_from_world * (p - seen->centre)))
            .normalized();
    const auto lit = static_cast<float>(0.3 + 0.7 * std::max(0.0, normal.dot(light)));
    return lit * Color(0.65F, 0.45F, 0.15F);
  }
  const double half = 0.5 * board.plate_m;
  if (std::abs(ground.x()) > half || std::abs(ground.y()) > half) return {0.05F, 0.35F, 0.08F};
  const auto falloff = static_cast<float>(1 - 1.5 * ground.x());  // the lamp stands on the left
  const bool black = is_black(board, ground.x(), ground.y());
  return falloff * (black ? Color(0.03F, 0.03F, 0.03F) : Color(0.78F, 0.78F, 0.76F));
}

void blur(Image<Color>& image, double sigma) {
  if (!(sigma > 0)) return;
  const int radius = static_cast<int>(std::ceil(4 * sigma));
  std::vector<float> kernel;
  // Integral of the Gaussian over each pixel.
  for (int i = -radius; i <= radius; ++i) {
    kernel.push_back(
        static_cast<float>(0.5 * (std::erf((i + 0.5) / (std::numbers::sqrt2 * sigma)) -
                                  std::erf((i - 0.5) / (std::numbers::sqrt2 * sigma)))));
  }
  const auto pass = [&](bool along_x) {
    const Image<Color> source = image;
    tbb::parallel_for(0, image.height(), [&](int y) {
      for (int x = 0; x < image.width(); ++x) {
        Color sum = Color::Zero();
        for (int i = -radius; i <= radius; ++i) {
          const int u = std::clamp(along_x ? x + i : x, 0, image.width() - 1);
          const int v = std::clamp(along_x ? y : y + i, 0, image.height() - 1);
          sum += kernel[static_cast<std::size_t>(i + radius)] * source(u, v);
        }
        image(x, y) = sum;
      }
    });
  };
  pass(true);
  pass(false);
}

std::uint8_t encode(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  const double s = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * s));
}

Pose increment(const Eigen::Vector3d& turn, const Eigen::Vector3d& shift) {
  Pose p;
  p.translation_m = shift;
  if (turn.norm() > 0)
    p.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  return p;
}

}  // namespace

Camera phone_camera(int width_px, LensModel model) {
  Camera c;
  c.model = model;
  c.width_px = width_px;
  c.height_px = width_px * 9 / 16;
  c.fx_px = c.fy_px = 0.84375 * width_px;
  c.cx_px = 0.5 * (c.width_px - 1) + 0.004 * width_px;
  c.cy_px = 0.5 * (c.height_px - 1) - 0.003 * width_px;
  switch (model) {
    case LensModel::pinhole:
      break;
    case LensModel::opencv5:
      c.distortion = {0.05, -0.08, 0.0004, -0.0003, 0.02};
      break;
    case LensModel::opencv8:
      c.distortion = {0.15, -0.05, 0.0004, -0.0003, 0.01, 0.1, -0.02, 0.005};
      break;
    case LensModel::opencv12:
      c.distortion = {0.15,  -0.05, 0.0004, -0.0003, 0.01,    0.1,
                      -0.02, 0.005, 0.001,  -0.0005, -0.0008, 0.0006};
      break;
    case LensModel::kannala_brandt4:
      c.distortion = {-0.02, 0.005, -0.003, 0.001};
      break;
    case LensModel::splined_stereographic:
      throw std::invalid_argument("phone_camera: no phone has a splined lens");
  }
  return c;
}

std::vector<Ellipsoid> seeds(Rng rng) {
  std::vector<Ellipsoid> result;
  for (int i = 0; i < 10; ++i) {
    Ellipsoid e;
    e.half_axes_m = {uniform(rng, 0.0025, 0.006), uniform(rng, 0.0012, 0.004),
                     uniform(rng, 0.001, 0.002)};
    e.centre_m = {0.012 * (i % 4 - 1.5) + uniform(rng, -0.003, 0.003),
                  0.014 * (i / 4 - 1) + uniform(rng, -0.003, 0.003), e.half_axes_m.z()};
    e.world_from_axes =
        Eigen::AngleAxisd(uniform(rng, 0, 2 * std::numbers::pi), Eigen::Vector3d::UnitZ())
            .toRotationMatrix();
    result.push_back(e);
  }
  return result;
}

Pose orbit(double distance_m, double elevation_rad, double azimuth_rad, double roll_rad,
           const Eigen::Vector3d& target_m) {
  const Eigen::Vector3d eye =
      distance_m * Eigen::Vector3d(std::cos(elevation_rad) * std::cos(azimuth_rad),
                                   std::cos(elevation_rad) * std::sin(azimuth_rad),
                                   std::sin(elevation_rad));
  return increment({0, 0, roll_rad}, Eigen::Vector3d::Zero()) * look_at(eye, target_m);
}

View hand_held(const Camera& camera, const Pose& camera_from_world, double shift_sigma_m,
               double turn_sigma_rad, Rng rng) {
  const auto three = [&] { return Eigen::Vector3d(normal(rng), normal(rng), normal(rng)); };
  const Eigen::Vector3d shift = shift_sigma_m * three(), turn = turn_sigma_rad * three();
  return {camera, camera_from_world, increment(turn, shift) * camera_from_world};
}

Pose pose_at_row(const View& view, double row) {
  return interpolate(view.camera_from_world, view.camera_from_world_end,
                     row / (view.camera.height_px - 1));
}

Pose middle_pose(const View& view) { return pose_at_row(view, 0.5 * (view.camera.height_px - 1)); }

Eigen::Vector2d true_pixel(const View& view, const Eigen::Vector3d& in_world_m) {
  Eigen::Vector2d pixel = project(view.camera, middle_pose(view) * in_world_m).value();
  for (int i = 0; i < 20; ++i)
    pixel = project(view.camera, pose_at_row(view, pixel.y()) * in_world_m).value();
  return pixel;
}

Image<Rgb8> photograph(const View& view, const SeedBoard& board,
                       const std::vector<Ellipsoid>& ellipsoids, const ImageConfig& config,
                       Rng rng) {
  const Camera& camera = view.camera;
  std::vector<LocalEllipsoid> local;
  for (const Ellipsoid& e : ellipsoids) {
    local.push_back(
        {e.half_axes_m.cwiseInverse().asDiagonal() * e.world_from_axes.transpose(), e.centre_m,
         // Seen from 12 degrees an ellipsoid hides ground five times its height behind it.
         e.half_axes_m.maxCoeff() + 10 * e.half_axes_m.z()});
  }
  Image<Color> linear(camera.width_px, camera.height_px, Color(0.05F, 0.35F, 0.08F));
  // Rows and columns that show the plate, and a little more.
  double x0 = 1e9, x1 = -1e9, y0 = 1e9, y1 = -1e9;
  for (int i = 0; i <= 10; ++i) {
    for (int j = 0; j <= 10; ++j) {
      const Eigen::Vector3d p(board.plate_m * (0.1 * i - 0.5), board.plate_m * (0.1 * j - 0.5), 0);
      const Eigen::Vector2d q = project(camera, middle_pose(view) * p).value();
      x0 = std::min(x0, q.x()), x1 = std::max(x1, q.x()), y0 = std::min(y0, q.y()),
      y1 = std::max(y1, q.y());
    }
  }
  const int left = std::clamp(static_cast<int>(x0) - 8, 0, camera.width_px - 1);
  const int right = std::clamp(static_cast<int>(x1) + 8, 0, camera.width_px - 1);
  const int top = std::clamp(static_cast<int>(y0) - 20, 0, camera.height_px - 1);
  const int bottom = std::clamp(static_cast<int>(y1) + 8, 0, camera.height_px - 1);
  tbb::parallel_for(top, bottom + 1, [&](int y) {
    Rng jitter = rng.fork("rays").fork(static_cast<std::uint64_t>(y));
    const Pose world_from_camera = inverse(pose_at_row(view, y));
    const Eigen::Matrix3d rotation = world_from_camera.rotation.toRotationMatrix();
    // Rays along the row's two edges, exact every fourth pixel: between them the lens is linear to
    // 3e-4 px.
    constexpr int kStep = 4;
    const auto edge = [&](double v) {
      std::vector<Eigen::Vector3d> nodes;
      for (int x = left; x <= right + kStep; x += kStep) {
        const Eigen::Vector3d ray = unproject(camera, Eigen::Vector2d(x - 0.5, v)).value();
        nodes.push_back(ray / ray.z());
      }
      return nodes;
    };
    const std::vector<Eigen::Vector3d> above = edge(y - 0.5), below = edge(y + 0.5);
    const auto between = [&](const std::vector<Eigen::Vector3d>& nodes, int x) -> Eigen::Vector3d {
      const auto i = static_cast<std::size_t>((x - left) / kStep);
      const double t = static_cast<double>((x - left) % kStep) / kStep;
      return t == 0 ? nodes[i] : Eigen::Vector3d((1 - t) * nodes[i] + t * nodes[i + 1]);
    };
    Eigen::Vector3d a = between(above, left), b = between(below, left);
    for (int x = left; x <= right; ++x) {
      const Eigen::Vector3d c = between(above, x + 1), d = between(below, x + 1);
      const auto look = [&](const Eigen::Vector3d& direction) {
        return shade(board, local, world_from_camera.translation_m, rotation * direction);
      };
      // A pixel whose corners and centre agree shows one surface: features are wider than half a
      // pixel.
      const std::array<Color, 5> probes = {look(a), look(b), look(c), look(d), look(a + b + c + d)};
      Color low = probes[0], high = probes[0], sum = Color::Zero();
      for (const Color& probe : probes) low = low.cwiseMin(probe), high = high.cwiseMax(probe);
      if ((high - low).maxCoeff() < 0.004F) {
        linear(x, y) = probes[4];
        a = c, b = d;
        continue;
      }
      // Fibonacci lattice under a random shift: an edge along a row meets no grid.
      const double shift_u = uniform(jitter), shift_v = uniform(jitter);
      for (int i = 0; i < kRays; ++i) {
        const double u = std::fmod((i + 0.5) / kRays + shift_u, 1);
        const double v = std::fmod(((34 * i) % kRays + 0.5) / kRays + shift_v, 1);
        const Eigen::Vector3d direction =
            (1 - v) * ((1 - u) * a + u * c) + v * ((1 - u) * b + u * d);
        sum += look(direction);
      }
      linear(x, y) = sum / static_cast<float>(kRays);
      a = c, b = d;
    }
  });
  blur(linear, config.blur_sigma_px);
  // The screen beyond the plate's surroundings stays without noise: nothing looks there, and it
  // costs most.
  const Color screen = linear(0, 0);
  Image<Rgb8> image(camera.width_px, camera.height_px,
                    {encode(screen[0]), encode(screen[1]), encode(screen[2])});
  tbb::parallel_for(top, bottom + 1, [&](int y) {
    Rng row = rng.fork(static_cast<std::uint64_t>(y));
    for (int x = left; x <= right; ++x) {
      std::array<std::uint8_t, 3> code{};
      for (int k = 0; k < 3; ++k) {
        double signal = linear(x, y)[k];
        if (config.noise) {
          const double variance =
              signal * config.electrons + config.read_noise_e * config.read_noise_e;
          signal += normal(row) * std::sqrt(variance) / config.electrons;
        }
        code[static_cast<std::size_t>(k)] = encode(signal);
      }
      image(x, y) = {code[0], code[1], code[2]};
    }
  });
  return image;
}

Shoot plan_shoot(const ShootConfig& config, Rng rng) {
  constexpr std::array<double, 3> kElevations = {0.26, 0.61, 1.05}, kDistances = {0.45, 0.40, 0.35};
  constexpr double kFocal =
      0.0042;  // m, of the lens: it moves out to focus, so the focal length in pixels grows
  const Camera truth = phone_camera(config.width_px, config.lens);
  Camera reported = truth;
  Rng report = rng.fork("report");
  const double factor = 1 + config.report_focal_error * (uniform(report) < 0.5 ? -1 : 1);
  reported.cx_px += config.report_centre_error_px * (uniform(report) < 0.5 ? -1 : 1);
  reported.cy_px += config.report_centre_error_px * (uniform(report) < 0.5 ? -1 : 1);
  for (double& k : reported.distortion)
    k *= 1 + config.report_distortion_error * truncated_normal(report, 0, 1);

  Shoot shoot;
  SensorReport sensor;
  sensor.camera = reported;
  sensor.shutter = config.readout_s > 0 ? Shutter::rolling : Shutter::global;
  sensor.readout_s = config.readout_s;
  shoot.capture.rig.push_back(sensor);
  shoot.capture.board = "markers";
  for (int i = 0; i < config.views; ++i) {
    Rng r = rng.fork(static_cast<std::uint64_t>(i));
    const auto ring = static_cast<std::size_t>(i * 3 / config.views);
    const double azimuth = 2 * std::numbers::pi * 3 * i / config.views;
    const double distance =
        config.distance_scale * kDistances[ring] * (1 + 0.05 * truncated_normal(r, 0, 1));
    const double elevation = kElevations[ring] + 0.05 * truncated_normal(r, 0, 1);
    const Eigen::Vector3d aim(uniform(r, -0.01, 0.01), uniform(r, -0.01, 0.01), 0);
    const Pose pose = orbit(distance, elevation, azimuth, 0.05 * truncated_normal(r, 0, 1), aim);
    Camera camera = truth, said = reported;
    Rng scale = r.fork("focus scale");
    const double told = distance * (1 + config.report_focus_error * truncated_normal(scale, 0, 1));
    const double breathing = 1 + kFocal / (told - kFocal);
    const double focused = distance * (1 + config.focus_error * truncated_normal(r, 0, 1));
    camera.fx_px *= 1 + kFocal / (focused - kFocal), camera.fy_px = camera.fx_px;
    said.fx_px *= factor * breathing, said.fy_px = said.fx_px;
    shoot.views.push_back(hand_held(camera, pose, config.readout_s * config.hand_speed_m_per_s,
                                    config.readout_s * config.hand_rate_rad_per_s, r.fork("hand")));
    Frame frame;
    frame.id = i;
    frame.time_s = i / 2.0;
    frame.sensors.resize(1);
    frame.sensors[0].reported = said;
    shoot.capture.frames.push_back(std::move(frame));
  }
  return shoot;
}

Shoot shoot(const ShootConfig& config, const SeedBoard& board, const ImageConfig& image, Rng rng) {
  Shoot result = plan_shoot(config, rng);
  const std::vector<Ellipsoid> ellipsoids =
      config.seeds ? seeds(rng.fork("seeds")) : std::vector<Ellipsoid>{};
  for (std::size_t i = 0; i < result.views.size(); ++i) {
    result.capture.frames[i].sensors[0].color =
        photograph(result.views[i], board, ellipsoids, image, rng.fork("image").fork(i));
  }
  return result;
}

}  // namespace cousin::synthetic
