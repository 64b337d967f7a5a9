#include "sim/render/scene_lights.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/render/sample_points.h"

namespace cousin {
namespace {

Eigen::Vector3f colour(const Rgbf& c, const char* what) {
  for (const float v : {c.r, c.g, c.b}) {
    if (!std::isfinite(v) || v < 0)
      throw std::invalid_argument(std::string(what) + ": negative or not finite");
  }
  return {c.r, c.g, c.b};
}

struct LightReader {
  SceneLights& lights;
  const Eigen::Vector3d& centre_m;

  void operator()(const Sun& sun) const {
    if (!sun.to_sun.allFinite() || sun.to_sun.norm() < 1e-6) {
      throw std::invalid_argument("sun: to_sun is zero or not finite");
    }
    if (!(sun.angular_radius_rad > 0 && sun.angular_radius_rad < 1)) {
      throw std::invalid_argument("sun: angular_radius_rad = " +
                                  std::to_string(sun.angular_radius_rad) + " is not in (0, 1)");
    }
    const double sine = std::sin(sun.angular_radius_rad);
    SceneLights::SunDisk disk;
    disk.to_sun = sun.to_sun.normalized().cast<float>();
    disk.cos_radius = static_cast<float>(std::cos(sun.angular_radius_rad));
    disk.irradiance = colour(sun.irradiance, "sun: irradiance");
    disk.radiance = disk.irradiance / static_cast<float>(std::numbers::pi * sine * sine);
    lights.suns.push_back(disk);
  }
  void operator()(const Sky& sky) const {
    lights.skies.push_back({colour(sky.zenith, "sky: zenith"), colour(sky.horizon, "sky: horizon"),
                            colour(sky.ground, "sky: ground")});
  }
  void operator()(const Lamp& lamp) const {
    const Eigen::Vector3d cross = lamp.axis_u_m.cross(lamp.axis_v_m);
    if (!cross.allFinite() || !(cross.norm() > 0) || !lamp.centre_in_world_m.allFinite()) {
      throw std::invalid_argument("lamp: its axes span no area, or a number is not finite");
    }
    SceneLights::LampFace face;
    face.centre_m = (lamp.centre_in_world_m - centre_m).cast<float>();
    face.axis_u_m = lamp.axis_u_m.cast<float>();
    face.axis_v_m = lamp.axis_v_m.cast<float>();
    face.normal = cross.normalized().cast<float>();
    face.area_m2 = static_cast<float>(4 * cross.norm());
    face.radiance = colour(lamp.radiance, "lamp: radiance");
    lights.lamps.push_back(face);
  }
  void operator()(const ClearSky&) const { refuse("clear sky"); }
  void operator()(const Projector&) const { refuse("projector"); }
  void operator()(const Environment&) const { refuse("environment"); }

  [[noreturn]] static void refuse(const char* what) {
    throw std::invalid_argument(std::string("irradiance cache: knows suns, skies and lamps; a ") +
                                what + " needs the path tracer");
  }
};

}  // namespace

SceneLights make_lights(const Scene& scene, const Eigen::Vector3d& centre_m) {
  SceneLights lights;
  for (const Light& light : scene.lights) std::visit(LightReader{lights, centre_m}, light);
  return lights;
}

Eigen::Vector3f sky_radiance(const SceneLights& lights, const Eigen::Vector3f& d) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const auto& sky : lights.skies) {
    sum +=
        d.z() < 0 ? sky.ground : Eigen::Vector3f(sky.horizon + d.z() * (sky.zenith - sky.horizon));
  }
  return sum;
}

Eigen::Vector3f sun_radiance(const SceneLights& lights, const Eigen::Vector3f& d) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const auto& sun : lights.suns) {
    if (d.dot(sun.to_sun) > sun.cos_radius) sum += sun.radiance;
  }
  return sum;
}

Eigen::Vector3f draw_sun(const SceneLights::SunDisk& sun, const Eigen::Vector2f& u) {
  const float sine = std::sqrt(std::max(0.0F, 1 - sun.cos_radius * sun.cos_radius));
  const Eigen::Vector2f disk = sine * concentric_disk(u);
  const float z = std::sqrt(std::max(0.0F, 1 - disk.squaredNorm()));
  return frame_about(sun.to_sun) * Eigen::Vector3f(disk.x(), disk.y(), z);
}

float hit_lamp(const SceneLights::LampFace& lamp, const Eigen::Vector3f& origin_m,
               const Eigen::Vector3f& direction, float far_m) {
  const float facing = -lamp.normal.dot(direction);
  if (facing <= 0) return 0;
  const Eigen::Vector3f to_centre = lamp.centre_m - origin_m;
  const float t = -lamp.normal.dot(to_centre) / facing;
  if (!(t > 0 && t < far_m)) return 0;
  // Coordinates on the face by the dual basis, so the axes need not be at right angles.
  const Eigen::Vector3f p = t * direction - to_centre;
  const float scale = 4 / lamp.area_m2;
  const float u = lamp.normal.dot(p.cross(lamp.axis_v_m)) * scale;
  const float v = lamp.normal.dot(lamp.axis_u_m.cross(p)) * scale;
  if (std::abs(u) > 1 || std::abs(v) > 1) return 0;
  return t * t / (lamp.area_m2 * facing);
}

LampDraw draw_lamp(const SceneLights::LampFace& lamp, const Eigen::Vector3f& from_m,
                   const Eigen::Vector2f& u) {
  const Eigen::Vector3f to =
      lamp.centre_m + (2 * u.x() - 1) * lamp.axis_u_m + (2 * u.y() - 1) * lamp.axis_v_m - from_m;
  const float distance2 = to.squaredNorm();
  LampDraw draw;
  draw.distance_m = std::sqrt(distance2);
  draw.direction = to / draw.distance_m;
  const float facing = -lamp.normal.dot(draw.direction);
  if (facing > 0) draw.density = distance2 / (lamp.area_m2 * facing);
  return draw;
}

}  // namespace cousin
