#include "sim/render/infrared_light.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "sim/render/clear_sky.h"
#include "sim/render/value_noise.h"

namespace cousin {
namespace {

float mean_of(const Rgbf& c) { return (c.r + c.g + c.b) / 3; }
float luminance(const Rgbf& c) { return 0.2126F * c.r + 0.7152F * c.g + 0.0722F * c.b; }

/// Irradiance of a dome that is even about the vertical on a surface tilted by acos(normal_z).
double dome_irradiance(const InfraredLights::Dome& dome, double normal_z) {
  const double normal_x = std::sqrt(std::max(0.0, 1 - normal_z * normal_z));
  constexpr int kUp = 64, kAround = 64;
  double sum = 0;
  for (int i = 0; i < kUp; ++i) {
    const double z = -1 + (i + 0.5) * 2 / kUp, r = std::sqrt(1 - z * z);
    for (int j = 0; j < kAround; ++j) {
      const double cosine =
          normal_z * z + normal_x * r * std::cos((j + 0.5) * 2 * std::numbers::pi / kAround);
      if (cosine > 0) sum += dome.radiance(z) * cosine;
    }
  }
  return sum * 4 * std::numbers::pi / (kUp * kAround);
}

/// Luminance of sunlight above the air, klux [CIE: 128 klux].
constexpr double kSolarIlluminance_klux = 128;
constexpr double kWavelength_m = 850e-9;
constexpr int kMostPasses = 64;  // a sample of 19 of the projector's pixels

double mean_radiance(const Environment& environment) {
  double sum = 0, weight = 0;
  for (int y = 0; y < environment.radiance.height(); ++y) {
    const double w =
        std::sin((y + 0.5) * std::numbers::pi / environment.radiance.height());  // solid angle
    for (const Rgbf& c : environment.radiance.row(y)) {
      sum += w * static_cast<double>(mean_of(c));
      weight += w;
    }
  }
  return weight > 0 ? sum / weight : 0;
}

/// Adds `variance_px2` to the second moment of whatever the rows hold, by three taps.
void widen_rows(Image<float>& image, double variance_px2) {
  const auto side = static_cast<float>(variance_px2 / 2);
  tbb::parallel_for(0, image.height(), [&](int y) {
    float* row = image.row(y).data();
    float before = row[0];
    for (int x = 0; x + 1 < image.width(); ++x) {
      const float own = row[x];
      row[x] += side * (before - 2 * own + row[x + 1]);
      before = own;
    }
  });
}

void widen_columns(Image<float>& image, double variance_px2) {
  const auto side = static_cast<float>(variance_px2 / 2);
  const int last = image.height() - 1;
  Image<float> out(image.width(), image.height());
  tbb::parallel_for(0, image.height(), [&](int y) {
    const float* above = image.row(std::max(y - 1, 0)).data();
    const float* below = image.row(std::min(y + 1, last)).data();
    const float* own = image.row(y).data();
    float* to = out.row(y).data();
    for (int x = 0; x < image.width(); ++x)
      to[x] = own[x] + side * (above[x] - 2 * own[x] + below[x]);
  });
  image = std::move(out);
}

/// Widens the picture as a mean over a square of side `square_px` does, to second order.
void widen(Image<float>& image, double square_x_px, double square_y_px) {
  constexpr double kMost_px2 = 0.5;  // that three taps can add
  const double x_px2 = square_x_px * square_x_px / 12, y_px2 = square_y_px * square_y_px / 12;
  const int passes =
      std::clamp(static_cast<int>(std::ceil(std::max(x_px2, y_px2) / kMost_px2)), 1, kMostPasses);
  for (int i = 0; i < passes; ++i) {
    widen_rows(image, std::min(x_px2 / passes, kMost_px2));
    widen_columns(image, std::min(y_px2 / passes, kMost_px2));
  }
}

InfraredProjector make_projector(const Projector& projector, const Eigen::Vector3d& centre_m,
                                 double sample_rad) {
  validate(projector.lens);
  if (projector.intensity.width() != projector.lens.width_px ||
      projector.intensity.height() != projector.lens.height_px) {
    throw std::invalid_argument(
        "infrared pass: a projector's picture is " + std::to_string(projector.intensity.width()) +
        " x " + std::to_string(projector.intensity.height()) + ", its lens " +
        std::to_string(projector.lens.width_px) + " x " + std::to_string(projector.lens.height_px));
  }
  InfraredProjector out;
  out.origin_m = (projector.world_from_projector.translation_m - centre_m).cast<float>();
  out.projector_from_world =
      projector.world_from_projector.rotation.conjugate().toRotationMatrix().cast<float>();
  out.lens = projector.lens;
  out.is_pinhole = projector.lens.model == LensModel::pinhole;
  out.intensity = Image<float>(projector.intensity.width(), projector.intensity.height());
  std::transform(projector.intensity.begin(), projector.intensity.end(), out.intensity.begin(),
                 [](const Rgbf& c) { return c.r; });
  if (out.intensity.width() > 0 && out.intensity.height() > 0)
    widen(out.intensity, sample_rad * out.lens.fx_px, sample_rad * out.lens.fy_px);
  return out;
}

/// A quadratic B-spline's three weights at a place, and the first pixel's.
struct Spline {
  int first;
  std::array<float, 3> weights;
};
Spline spline(float place) {
  const float nearest = std::floor(place + 0.5F), t = place - nearest;
  return {static_cast<int>(nearest) - 1,
          {0.5F * (0.5F - t) * (0.5F - t), 0.75F - t * t, 0.5F * (0.5F + t) * (0.5F + t)}};
}

}  // namespace

float InfraredProjector::towards(const Eigen::Vector3f& offset_m) const {
  const Eigen::Vector3f p = projector_from_world * offset_m;
  Eigen::Vector2f pixel;
  if (is_pinhole) {
    if (p.z() <= 0) return 0;
    const float inverse = 1 / p.z();
    pixel.x() = static_cast<float>(lens.fx_px) * p.x() * inverse + static_cast<float>(lens.cx_px);
    pixel.y() = static_cast<float>(lens.fy_px) * p.y() * inverse + static_cast<float>(lens.cy_px);
  } else {
    const auto projected = project(lens, p.cast<double>());
    if (!projected) return 0;
    pixel = projected->cast<float>();
  }
  const auto last_x = static_cast<float>(intensity.width() - 1);
  const auto last_y = static_cast<float>(intensity.height() - 1);
  if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= last_x && pixel.y() <= last_y)) return 0;
  const auto [x, across] = spline(pixel.x());
  const auto [y, down] = spline(pixel.y());
  const int last_column = intensity.width() - 1, last_row = intensity.height() - 1;
  float sum = 0;
  for (int j = 0; j < 3; ++j) {
    const float* row = intensity.row(std::clamp(y + j, 0, last_row)).data();
    float along = 0;
    for (int i = 0; i < 3; ++i)
      along += across[static_cast<std::size_t>(i)] * row[std::clamp(x + i, 0, last_column)];
    sum += down[static_cast<std::size_t>(j)] * along;
  }
  return sum;
}

float InfraredLights::ambient_at(float normal_z) const {
  const float position =
      0.5F * (std::clamp(normal_z, -1.0F, 1.0F) + 1) * static_cast<float>(ambient.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(position), ambient.size() - 2);
  const float t = position - static_cast<float>(i);
  return ambient[i] * (1 - t) + ambient[i + 1] * t;
}

InfraredLights make_infrared_lights(const Scene& scene, std::span<const Projector> projectors,
                                    const InfraredConfig& config, const Eigen::Vector3d& centre_m,
                                    double sample_rad) {
  InfraredLights lights;
  InfraredLights::Dome& dome = lights.dome;
  for (const Projector& projector : projectors)
    lights.projectors.push_back(make_projector(projector, centre_m, sample_rad));
  const auto add_sun = [&](const Eigen::Vector3d& to_sun, double irradiance) {
    lights.suns.push_back({to_sun.normalized().cast<float>(), static_cast<float>(irradiance)});
  };
  for (const Light& light : scene.lights) {
    if (const auto* sun = std::get_if<Sun>(&light)) {
      add_sun(sun->to_sun, config.sun_share * static_cast<double>(mean_of(sun->irradiance)));
    } else if (const auto* sky = std::get_if<Sky>(&light)) {
      dome.zenith += config.sky_share * static_cast<double>(mean_of(sky->zenith));
      dome.horizon += config.sky_share * static_cast<double>(mean_of(sky->horizon));
      dome.ground += config.sky_share * static_cast<double>(mean_of(sky->ground));
    } else if (const auto* clear = std::get_if<ClearSky>(&light)) {
      const double direct =
          kSolarIlluminance_klux * clear->scale * clear_air_transmittance(*clear, kWavelength_m);
      if (clear->has_sun) add_sun(clear->to_sun, config.sun_share * direct);
      // A tenth of the sunlight is scattered by clear air at 550 nm, evenly to our eyes.
      const double even = config.sky_share * 0.1 * direct / std::numbers::pi;
      dome.zenith += even;
      dome.horizon += even;
      dome.ground += static_cast<double>(mean_of(clear->ground_albedo)) * config.sun_share *
                     direct * std::max(0.0, clear->to_sun.normalized().z()) / std::numbers::pi;
    } else if (const auto* lamp = std::get_if<Lamp>(&light)) {
      const Eigen::Vector3d normal = lamp->axis_u_m.cross(lamp->axis_v_m);
      lights.lamps.push_back({(lamp->centre_in_world_m - centre_m).cast<float>(),
                              normal.normalized().cast<float>(), lamp->axis_u_m.cast<float>(),
                              lamp->axis_v_m.cast<float>(),
                              static_cast<float>(config.lamp_share * 4 * normal.norm() *
                                                 static_cast<double>(mean_of(lamp->radiance)))});
    } else if (const auto* environment = std::get_if<Environment>(&light)) {
      const double even = config.sky_share * mean_radiance(*environment);
      dome.zenith += even;
      dome.horizon += even;
      dome.ground += even;
    } else if (const auto* projector = std::get_if<Projector>(&light)) {
      lights.projectors.push_back(make_projector(*projector, centre_m, sample_rad));
    }
  }
  if (config.lamp_share == 0) lights.lamps.clear();
  for (std::size_t i = 0; i < lights.ambient.size(); ++i) {
    const double normal_z = -1 + 2 * static_cast<double>(i) / double(lights.ambient.size() - 1);
    lights.ambient[i] = static_cast<float>(dome_irradiance(dome, normal_z));
  }
  return lights;
}

InfraredSurface::Share InfraredSurface::at(const Eigen::Vector3f& position_m, std::uint16_t part,
                                           bool has_print) const {
  const InfraredLook& look = looks[looks.size() > 1 ? part : 0];
  const bool is_printed = look.print && has_print;
  if (look.octaves == 0 && !is_printed) return {look.albedo, look.transmittance};
  const Eigen::Vector3f p = object_from_world * position_m + object_origin_m;
  if (is_printed && is_black(*look.print, static_cast<double>(p.x()), static_cast<double>(p.y()))) {
    return {look.ink_albedo, 0};
  }
  if (look.octaves == 0) return {look.albedo, look.transmittance};
  const float t = value_noise(p / static_cast<float>(look.scale_m), look.octaves);
  const float factor = 1 - t + t * look.noise_ratio;
  return {std::clamp(look.albedo * factor, 0.0F, 1 - look.transmittance), look.transmittance};
}

namespace {

InfraredLook look_of(const Material& m) {
  InfraredLook look;
  look.albedo = m.infrared_albedo;
  look.transmittance = m.infrared_transmittance;
  if (m.infrared_noise) {
    look.noise_ratio = m.infrared_noise->other_albedo / std::max(look.albedo, 1e-3F);
    look.scale_m = m.infrared_noise->scale_m;
    look.octaves = m.infrared_noise->octaves;
  } else if (m.noise) {
    // As bright and dark as what is seen.
    look.noise_ratio = luminance(m.noise->other_albedo) / std::max(luminance(m.albedo), 1e-3F);
    look.scale_m = m.noise->scale_m;
    look.octaves = m.noise->octaves;
  }
  look.print = m.print;
  look.ink_albedo = luminance(m.ink_albedo);
  return look;
}

}  // namespace

std::vector<InfraredSurface> make_infrared_surfaces(const Scene& scene, double time_s,
                                                    const Eigen::Vector3d& centre_m) {
  std::vector<InfraredSurface> surfaces(scene.instances.size());
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const Instance& instance = scene.instances[i];
    InfraredSurface& s = surfaces[i];
    for (const int part : instance.part_materials)
      s.looks.push_back(look_of(scene.materials[static_cast<std::size_t>(part)]));
    if (s.looks.empty())
      s.looks.push_back(look_of(scene.materials[static_cast<std::size_t>(instance.material)]));
    const Pose object_from_world = inverse(world_from_object(instance, time_s));
    s.object_from_world = object_from_world.rotation.toRotationMatrix().cast<float>();
    s.object_origin_m = (object_from_world * centre_m).cast<float>();
  }
  return surfaces;
}

}  // namespace cousin
