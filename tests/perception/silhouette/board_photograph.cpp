#include "tests/perception/silhouette/board_photograph.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "sim/imaging/color.h"

namespace cousin {
namespace {

std::optional<double> hit(const CastEllipsoid& object, const Eigen::Vector3d& eye,
                          const Eigen::Vector3d& ray) {
  const Eigen::Vector3d o = (eye - object.centre_m).cwiseQuotient(object.semi_axes_m);
  const Eigen::Vector3d d = ray.cwiseQuotient(object.semi_axes_m);
  const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - 1;
  const double root = b * b - a * c;
  if (root < 0) return std::nullopt;
  return (-b - std::sqrt(root)) / a;
}

Eigen::Vector3d radiance(const std::vector<CastEllipsoid>& objects, const SeedBoard& board,
                         const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) {
  const CastEllipsoid* first = nullptr;
  double nearest = 1e9;
  for (const CastEllipsoid& object : objects) {
    const auto t = hit(object, eye, ray);
    if (t && *t < nearest) {
      nearest = *t;
      first = &object;
    }
  }
  if (first != nullptr) {
    const Eigen::Vector3d on_unit =
        (eye + nearest * ray - first->centre_m).cwiseQuotient(first->semi_axes_m);
    const double up = on_unit.cwiseQuotient(first->semi_axes_m).normalized().z();
    return first->albedo * (0.65 + 0.35 * up);
  }
  const Eigen::Vector3d ground = eye - ray * (eye.z() / ray.z());
  double light = 0.9;
  for (const CastEllipsoid& object : objects) {
    // Darkest under the object, gone two of its heights away.
    const Eigen::Vector2d across =
        (ground - object.centre_m).head<2>().cwiseQuotient(object.semi_axes_m.head<2>());
    const double outside_m =
        std::max(0.0, across.norm() - 1) * object.semi_axes_m.head<2>().minCoeff();
    light *= 1 - 0.5 * std::exp(-outside_m / object.semi_axes_m.z());
  }
  const double albedo = is_black(board, ground.x(), ground.y()) ? 0.05 : 0.8;
  return Eigen::Vector3d::Constant(albedo * light);
}

/// Each channel with a separable Gaussian.
void blur(Image<Eigen::Vector3d>& image, double sigma_px) {
  std::array<double, 7> kernel{};
  double sum = 0;
  for (int k = -3; k <= 3; ++k)
    sum += kernel[static_cast<std::size_t>(k + 3)] = std::exp(-0.5 * k * k / (sigma_px * sigma_px));
  for (double& weight : kernel) weight /= sum;
  for (int axis = 0; axis < 2; ++axis) {
    const Image<Eigen::Vector3d> source = image;
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        Eigen::Vector3d value = Eigen::Vector3d::Zero();
        for (int k = -3; k <= 3; ++k) {
          const int u = std::clamp(axis == 0 ? x + k : x, 0, image.width() - 1);
          const int v = std::clamp(axis == 1 ? y + k : y, 0, image.height() - 1);
          value += kernel[static_cast<std::size_t>(k + 3)] * source(u, v);
        }
        image(x, y) = value;
      }
    }
  }
}

}  // namespace

FramePose small_pose(int frame, double azimuth_rad, double elevation_rad, double distance_m) {
  const Eigen::Vector3d direction(std::cos(azimuth_rad) * std::cos(elevation_rad),
                                  std::sin(azimuth_rad) * std::cos(elevation_rad),
                                  std::sin(elevation_rad));
  FramePose pose;
  pose.frame = frame;
  pose.status = PoseStatus::ok;
  pose.camera_from_world = look_at(distance_m * direction, Eigen::Vector3d(0, 0, 0.001));
  pose.camera = {LensModel::pinhole, 140, 110, 1080, 1080, 69.7, 54.2, {}};
  return pose;
}

Image<Rgb8> photograph(const std::vector<CastEllipsoid>& objects, const SeedBoard& board,
                       const FramePose& pose, double blur_sigma_px, Rng rng) {
  constexpr int kSamples = 6;
  constexpr double kElectrons = 6000;  // at radiance 1
  const Camera& camera = pose.camera;
  const Eigen::Vector3d eye = centre_in_world_m(pose.camera_from_world);
  const Eigen::Quaterniond world_from_camera = pose.camera_from_world.rotation.conjugate();
  Image<Eigen::Vector3d> linear(camera.width_px, camera.height_px, Eigen::Vector3d::Zero());
  for (int y = 0; y < camera.height_px; ++y) {
    for (int x = 0; x < camera.width_px; ++x) {
      for (int s = 0; s < kSamples * kSamples; ++s) {
        const double u = x - 0.5 + (s % kSamples + 0.5) / kSamples,
                     v = y - 0.5 + (s / kSamples + 0.5) / kSamples;
        const Eigen::Vector3d ray((u - camera.cx_px) / camera.fx_px,
                                  (v - camera.cy_px) / camera.fy_px, 1);
        linear(x, y) +=
            radiance(objects, board, eye, world_from_camera * ray) / (kSamples * kSamples);
      }
    }
  }
  blur(linear, blur_sigma_px);
  Image<Rgb8> image(camera.width_px, camera.height_px);
  for (int y = 0; y < camera.height_px; ++y) {
    Rng draw = rng.fork(static_cast<std::uint64_t>(y));
    for (int x = 0; x < camera.width_px; ++x) {
      std::array<std::uint8_t, 3> codes{};
      for (int channel = 0; channel < 3; ++channel) {
        const double value = linear(x, y)[channel];
        const double noisy = value + std::sqrt(std::max(0.0, value) / kElectrons) * normal(draw);
        codes[static_cast<std::size_t>(channel)] = srgb8_from_linear(static_cast<float>(noisy));
      }
      image(x, y) = {codes[0], codes[1], codes[2]};
    }
  }
  return image;
}

}  // namespace cousin
