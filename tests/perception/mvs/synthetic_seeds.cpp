#include "tests/perception/mvs/synthetic_seeds.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "sim/types/rng.h"

namespace cousin {
namespace {

/// Uniform value of a lattice point, in [-1, 1].
double lattice(std::int64_t x, std::int64_t y, std::int64_t z) {
  auto h = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15ULL ^
           static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4FULL ^
           static_cast<std::uint64_t>(z) * 0x165667B19E3779F9ULL;
  h ^= h >> 31U;
  h *= 0xD6E8FEB86659FD93ULL;
  h ^= h >> 32U;
  return static_cast<double>(h >> 11U) * 0x1p-52 - 1;
}

/// Smooth noise of unit lattice.
double noise(const Eigen::Vector3d& p) {
  const Eigen::Vector3d base = p.array().floor();
  const Eigen::Vector3d f = p - base;
  const Eigen::Vector3d s = f.array() * f.array() * (3 - 2 * f.array());
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const int dx = i & 1, dy = (i >> 1) & 1, dz = i >> 2;
    const double weight =
        (dx ? s.x() : 1 - s.x()) * (dy ? s.y() : 1 - s.y()) * (dz ? s.z() : 1 - s.z());
    sum += weight * lattice(static_cast<std::int64_t>(base.x()) + dx,
                            static_cast<std::int64_t>(base.y()) + dy,
                            static_cast<std::int64_t>(base.z()) + dz);
  }
  return sum;
}

Eigen::Vector3d in_seed(const SyntheticSeed& seed, const Eigen::Vector3d& v) {
  const double c = std::cos(seed.yaw_rad), s = std::sin(seed.yaw_rad);
  return {c * v.x() + s * v.y(), -s * v.x() + c * v.y(), v.z()};
}

/// Distance to the near side of a seed along a unit ray.
std::optional<double> meet(const SyntheticSeed& seed, const Eigen::Vector3d& origin,
                           const Eigen::Vector3d& direction) {
  const Eigen::Vector3d o =
      in_seed(seed, origin - seed.centre_in_world_m()).cwiseQuotient(seed.radii_m);
  const Eigen::Vector3d d = in_seed(seed, direction).cwiseQuotient(seed.radii_m);
  const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - 1;
  const double discriminant = b * b - a * c;
  if (discriminant < 0) return std::nullopt;
  const double t = (-b - std::sqrt(discriminant)) / a;
  return t > 0 ? std::optional(t) : std::nullopt;
}

Eigen::Vector3d linear_color(const SyntheticScene& scene, const Eigen::Vector3d& origin,
                             const Eigen::Vector3d& direction) {
  const SyntheticHit hit = trace(scene, origin, direction);
  if (hit.object == -2) return {0.05, 0.5, 0.08};  // green screen
  const Eigen::Vector3d p = origin + hit.distance_m * direction;
  if (hit.object == -1) {
    return Eigen::Vector3d::Constant(is_black(scene.board, p.x(), p.y()) ? 0.04 : 0.75);
  }
  const SyntheticSeed& seed = scene.seeds[static_cast<std::size_t>(hit.object)];
  const Eigen::Vector3d local = p - seed.centre_in_world_m();
  const double c = std::cos(seed.yaw_rad), s = std::sin(seed.yaw_rad);
  const Eigen::Vector3d q = in_seed(seed, local).cwiseQuotient(seed.radii_m.cwiseAbs2());
  const Eigen::Vector3d normal =
      Eigen::Vector3d(c * q.x() - s * q.y(), s * q.x() + c * q.y(), q.z()).normalized();
  const double light =
      0.55 + 0.25 * normal.z() + 0.2 * std::max(0.0, normal.dot(Eigen::Vector3d(0.5, 0.3, 0.8)));
  const double pattern = 1 + scene.texture * (0.6 * noise(p / 0.0008) + 0.6 * noise(p / 0.0019));
  const Eigen::Vector3d base =
      seed.colored ? Eigen::Vector3d(0.65, 0.42, 0.14) : Eigen::Vector3d(0.4, 0.4, 0.4);
  return base * (light * pattern);
}

std::uint8_t srgb_code(double linear, double noise_codes, Rng& rng) {
  const double v = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
  const double code = 255 * v + noise_codes * normal(rng);
  return static_cast<std::uint8_t>(std::lround(std::min(255.0, std::max(0.0, code))));
}

}  // namespace

Eigen::Vector3d outward_normal(const SyntheticSeed& seed, const Eigen::Vector3d& in_world_m) {
  const Eigen::Matrix3d turned =
      Eigen::AngleAxisd(seed.yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Vector3d own = turned.transpose() * (in_world_m - seed.centre_in_world_m());
  return turned * own.cwiseQuotient(seed.radii_m.cwiseAbs2()).normalized();
}

SyntheticHit trace(const SyntheticScene& scene, const Eigen::Vector3d& origin,
                   const Eigen::Vector3d& direction) {
  SyntheticHit best;
  const double t = -origin.z() / direction.z();
  const Eigen::Vector3d p = origin + t * direction;
  const double half = 0.5 * scene.board.plate_m;
  if (t > 0 && std::abs(p.x()) <= half && std::abs(p.y()) <= half) best = {-1, t};
  for (std::size_t i = 0; i < scene.seeds.size(); ++i) {
    const auto distance = meet(scene.seeds[i], origin, direction);
    if (distance && (best.object == -2 || *distance < best.distance_m)) {
      best = {static_cast<int>(i), *distance};
    }
  }
  return best;
}

SyntheticViews make_views(const SyntheticScene& scene, const Camera& camera,
                          const std::vector<Eigen::Vector3d>& eyes, std::uint64_t seed) {
  const int w = camera.width_px, h = camera.height_px, n = scene.supersampling;
  // The lens's rays at pixel centres; samples inside a pixel follow by central differences.
  Image<Eigen::Vector2d> rays(w + 2, h + 2);
  tbb::parallel_for(0, h + 2, [&](int y) {
    for (int x = 0; x < w + 2; ++x) {
      const auto ray = unproject(camera, {x - 1.0, y - 1.0});
      rays(x, y) =
          ray ? Eigen::Vector2d(ray->head<2>() / ray->z()) : Eigen::Vector2d::Constant(kNaN);
    }
  });
  SyntheticViews views;
  views.capture.rig.push_back({"rgb", camera});
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const Pose camera_from_world = look_at(eyes[i], {0, 0, 0.002});
    const Eigen::Matrix3d world_from_camera =
        camera_from_world.rotation.toRotationMatrix().transpose();
    Image<Rgb8> color(w, h);
    Image<float> depth_m(w, h, std::numeric_limits<float>::quiet_NaN());
    Image<std::int8_t> object(w, h, -2);
    const Rng rng = Rng(seed).fork(i);
    tbb::parallel_for(0, h, [&](int y) {
      Rng draws = rng.fork(static_cast<std::uint64_t>(y));
      for (int x = 0; x < w; ++x) {
        const Eigen::Vector2d ray = rays(x + 1, y + 1);
        if (!ray.allFinite()) continue;
        const Eigen::Vector2d dx = 0.5 * (rays(x + 2, y + 1) - rays(x, y + 1));
        const Eigen::Vector2d dy = 0.5 * (rays(x + 1, y + 2) - rays(x + 1, y));
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int k = 0; k < n * n; ++k) {
          const double u = scene.footprint_px * ((k % n + 0.5) / n - 0.5);
          const double v = scene.footprint_px * ((k / n + 0.5) / n - 0.5);
          const Eigen::Vector2d r = ray + dx * u + dy * v;
          sum += linear_color(scene, eyes[i], (world_from_camera * r.homogeneous()).normalized());
        }
        sum /= n * n;
        color(x, y) = {srgb_code(sum.x(), scene.noise_codes, draws),
                       srgb_code(sum.y(), scene.noise_codes, draws),
                       srgb_code(sum.z(), scene.noise_codes, draws)};
        const SyntheticHit hit =
            trace(scene, eyes[i], (world_from_camera * ray.homogeneous()).normalized());
        object(x, y) = static_cast<std::int8_t>(hit.object);
        if (hit.object > -2) {
          depth_m(x, y) = static_cast<float>(hit.distance_m / ray.homogeneous().norm());
        }
      }
    });
    Frame frame;
    frame.id = static_cast<int>(i);
    frame.sensors.push_back({camera, std::move(color)});
    views.capture.frames.push_back(std::move(frame));
    FramePose pose;
    pose.frame = static_cast<int>(i);
    pose.status = PoseStatus::ok;
    pose.camera_from_world = camera_from_world;
    pose.camera = camera;
    views.poses.push_back(pose);
    views.depth_m.push_back(std::move(depth_m));
    views.object.push_back(std::move(object));
  }
  return views;
}

std::vector<Eigen::Vector3d> three_rings(int views, double nearest_m, double farthest_m) {
  std::vector<Eigen::Vector3d> eyes;
  constexpr double kElevations[] = {35, 55, 75};
  for (int i = 0; i < views; ++i) {
    const int ring = i * 3 / views;
    const double elevation = kElevations[ring] * std::numbers::pi / 180;
    const double azimuth = 2 * std::numbers::pi * (i * 3.0 / views - ring + 0.1 * ring);
    const double distance = nearest_m + (farthest_m - nearest_m) * ((i * 7) % 11) / 10.0;
    eyes.emplace_back(distance * std::cos(elevation) * std::cos(azimuth),
                      distance * std::cos(elevation) * std::sin(azimuth),
                      distance * std::sin(elevation));
  }
  return eyes;
}

SyntheticScene ten_seeds() {
  SyntheticScene scene;
  const Eigen::Vector3d sizes[] = {
      {0.0055, 0.0042, 0.0024}, {0.0031, 0.0016, 0.0014}, {0.0045, 0.0013, 0.0010}};
  for (int i = 0; i < 10; ++i) {
    const double angle = 2.4 * i;  // golden angle: even spacing
    const double radius = 0.011 * std::sqrt(i + 0.5);
    scene.seeds.push_back(
        {radius * std::cos(angle), radius * std::sin(angle), sizes[i % 3], 0.7 * i});
  }
  return scene;
}

Camera synthetic_camera(LensModel model, int width_px, int height_px, double focal_px) {
  Camera camera;
  camera.model = model;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.fx_px = focal_px;
  camera.fy_px = 1.01 * focal_px;
  camera.cx_px = 0.5 * (width_px - 1) + 3.3;
  camera.cy_px = 0.5 * (height_px - 1) - 2.1;
  if (model == LensModel::kannala_brandt4) {
    camera.distortion = {0.02, -0.01, 0.004, -0.001};
    return camera;
  }
  const std::array<double, 12> all = {0.08,  -0.2, 0.001, -0.0008, 0.1,    0.02,
                                      -0.05, 0.01, 0.001, -0.0005, 0.0008, 0.0003};
  for (int i = 0; i < distortion_count(model); ++i) {
    camera.distortion[static_cast<std::size_t>(i)] = all[static_cast<std::size_t>(i)];
  }
  return camera;
}

}  // namespace cousin
