#include "sim/render/scene_lights.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "sim/render/clear_sky.h"
#include "sim/render/sample_points.h"
#include "sim/truth/scene_check.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

Eigen::Vector3f colour(const Rgbf& c) { return {c.r, c.g, c.b}; }

// ---- pictures of the sky ------------------------------------------------------------------------

SceneLights::SkyPicture blank_picture(int width, int height) {
  SceneLights::SkyPicture picture;
  picture.width = width;
  picture.height = height;
  picture.radiance.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  return picture;
}

std::size_t texel_index(const SceneLights::SkyPicture& picture, int x, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
         static_cast<std::size_t>(x);
}

Eigen::Vector3f& texel(SceneLights::SkyPicture& picture, int x, int y) {
  return picture.radiance[texel_index(picture, x, y)];
}

Eigen::Vector3d texel_direction(const SceneLights::SkyPicture& picture, double x, double y) {
  const double polar = std::numbers::pi * (y + 0.5) / picture.height;
  const double azimuth = std::numbers::pi * (2 * (x + 0.5) / picture.width - 1);
  return {std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
          std::cos(polar)};
}

/// Position in the picture of a unit direction, in texels from the upper left corner.
Eigen::Vector2f picture_position(const SceneLights::SkyPicture& picture, const Eigen::Vector3f& d) {
  return {(std::atan2(d.y(), d.x()) / (2 * kPiF) + 0.5F) * static_cast<float>(picture.width),
          std::acos(std::clamp(d.z(), -1.0F, 1.0F)) / kPiF * static_cast<float>(picture.height)};
}

/// Solid angle of a texel of row `y`.
double texel_solid_angle(const SceneLights::SkyPicture& picture, int y) {
  const double step = std::numbers::pi / picture.height;
  return 2 * std::numbers::pi / picture.width * (std::cos(step * y) - std::cos(step * (y + 1)));
}

double luminance(const Eigen::Vector3f& c) {
  return 0.2126 * static_cast<double>(c.x()) + 0.7152 * static_cast<double>(c.y()) +
         0.0722 * static_cast<double>(c.z());
}

/// Running sums for drawing. A texel's weight is its brightest neighbour's, as light is bilinear
/// between centres; a dark picture keeps no sums.
void add_sums(SceneLights::SkyPicture& picture) {
  const int w = picture.width, h = picture.height;
  std::vector<double> rows(static_cast<std::size_t>(h));
  std::vector<double> texels(picture.radiance.size());
  double total = 0;
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      double brightest = 0;
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, h - 1); ++v) {
        for (int u = x - 1; u <= x + 1; ++u) {
          brightest = std::max(brightest,
                               luminance(picture.radiance[texel_index(picture, (u + w) % w, v)]));
        }
      }
      const double weight = brightest * texel_solid_angle(picture, y);
      texels[texel_index(picture, x, y)] = weight;
      rows[static_cast<std::size_t>(y)] += weight;
    }
    total += rows[static_cast<std::size_t>(y)];
  }
  if (!(total > 0)) return;
  double sum = 0;
  for (int y = 0; y < h; ++y) {
    sum += rows[static_cast<std::size_t>(y)] / total;
    picture.row_sums.push_back(y + 1 == h ? 1.0F : static_cast<float>(sum));
    double across = 0;
    for (int x = 0; x < w; ++x) {
      const double row = rows[static_cast<std::size_t>(y)];
      across += row > 0 ? texels[texel_index(picture, x, y)] / row : 1.0 / w;
      picture.column_sums.push_back(x + 1 == w ? 1.0F : static_cast<float>(across));
    }
  }
}

/// First entry of a running sum above `u`, and where `u` lies between it and the one before.
struct SumCell {
  int index = 0;
  float fraction = 0;
  float share = 0;
};
SumCell find_cell(const float* sums, int count, float u) {
  const float* found = std::upper_bound(sums, sums + count - 1, u);
  const auto index = static_cast<int>(found - sums);
  const float before = index > 0 ? sums[index - 1] : 0;
  const float share = *found - before;
  return {index, share > 0 ? std::clamp((u - before) / share, 0.0F, 0.99999994F) : 0.5F, share};
}

// ---- lights of a scene --------------------------------------------------------------------------

struct LightReader {
  SceneLights& lights;
  const Eigen::Vector3d& centre_m;

  void operator()(const Sun& sun) const {
    const double sine = std::sin(sun.angular_radius_rad);
    SceneLights::SunDisk disk;
    disk.to_sun = sun.to_sun.normalized().cast<float>();
    disk.sin_radius = static_cast<float>(sine);
    disk.chord = static_cast<float>(2 * std::sin(0.5 * sun.angular_radius_rad));
    disk.irradiance = colour(sun.irradiance);
    disk.radiance = disk.irradiance / static_cast<float>(std::numbers::pi * sine * sine);
    lights.suns.push_back(disk);
  }
  void operator()(const Sky& sky) const {
    lights.skies.push_back({colour(sky.zenith), colour(sky.horizon), colour(sky.ground)});
  }
  void operator()(const Lamp& lamp) const {
    const Eigen::Vector3d cross = lamp.axis_u_m.cross(lamp.axis_v_m);
    SceneLights::LampFace face;
    face.centre_m = (lamp.centre_in_world_m - centre_m).cast<float>();
    face.axis_u_m = lamp.axis_u_m.cast<float>();
    face.axis_v_m = lamp.axis_v_m.cast<float>();
    face.normal = cross.normalized().cast<float>();
    face.area_m2 = static_cast<float>(4 * cross.norm());
    face.radiance = colour(lamp.radiance);
    lights.lamps.push_back(face);
  }
  void operator()(const ClearSky& sky) const {
    const ClearSkyModel model(sky);
    const Eigen::Vector3d& sun = model.sun_irradiance();
    if (sun.maxCoeff() > 0) {
      (*this)(Sun{sky.to_sun, sky.angular_radius_rad,
                  Rgbf{static_cast<float>(sun.x()), static_cast<float>(sun.y()),
                       static_cast<float>(sun.z())}});
    }
    const Eigen::Vector3d ground =
        Eigen::Vector3d(sky.ground_albedo.r, sky.ground_albedo.g, sky.ground_albedo.b)
            .cwiseProduct(model.horizontal_irradiance()) /
        std::numbers::pi;
    SceneLights::SkyPicture picture = blank_picture(512, 256);
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        const Eigen::Vector3d d = texel_direction(picture, x, y);
        texel(picture, x, y) = (d.z() > 0 ? model.radiance(d) : ground).cast<float>();
      }
    }
    lights.pictures.push_back(std::move(picture));
  }
  void operator()(const Projector& projector) const {
    const Pose& pose = projector.world_from_projector;
    lights.beams.push_back({pose.rotation.conjugate().toRotationMatrix().cast<float>(),
                            (pose.translation_m - centre_m).cast<float>(), projector.lens,
                            projector.intensity});
  }
  void operator()(const Environment& environment) const {
    const Image<Rgbf>& image = environment.radiance;
    SceneLights::SkyPicture picture = blank_picture(image.width(), image.height());
    for (std::size_t i = 0; i < image.size(); ++i) picture.radiance[i] = colour(image.data()[i]);
    add_sums(picture);
    lights.pictures.push_back(std::move(picture));
  }
};

}  // namespace

SceneLights make_lights(const Scene& scene, const Eigen::Vector3d& centre_m) {
  SceneLights lights;
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    validate(scene.lights[i], "scene \"" + scene.name + "\", light " + std::to_string(i));
    std::visit(LightReader{lights, centre_m}, scene.lights[i]);
  }
  return lights;
}

Eigen::Vector3f dome_radiance(const SceneLights& lights, const Eigen::Vector3f& d) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const auto& sky : lights.skies) {
    sum +=
        d.z() < 0 ? sky.ground : Eigen::Vector3f(sky.horizon + d.z() * (sky.zenith - sky.horizon));
  }
  return sum;
}

Eigen::Vector3f sky_radiance(const SceneLights& lights, const Eigen::Vector3f& d) {
  Eigen::Vector3f sum = dome_radiance(lights, d);
  for (const auto& picture : lights.pictures) sum += picture_radiance(picture, d);
  return sum;
}

Eigen::Vector3f picture_radiance(const SceneLights::SkyPicture& picture, const Eigen::Vector3f& d) {
  const Eigen::Vector2f p = picture_position(picture, d) - Eigen::Vector2f::Constant(0.5F);
  const float fx = std::floor(p.x()), fy = std::floor(p.y());
  const int w = picture.width, h = picture.height;
  const int x0 = (static_cast<int>(fx) + w) % w, x1 = (x0 + 1) % w;
  const int y0 = std::clamp(static_cast<int>(fy), 0, h - 1);
  const int y1 = std::clamp(static_cast<int>(fy) + 1, 0, h - 1);
  const float u = p.x() - fx, v = p.y() - fy;
  const Eigen::Vector3f* row0 = picture.radiance.data() + texel_index(picture, 0, y0);
  const Eigen::Vector3f* row1 = picture.radiance.data() + texel_index(picture, 0, y1);
  return (1 - v) * ((1 - u) * row0[x0] + u * row0[x1]) + v * ((1 - u) * row1[x0] + u * row1[x1]);
}

float picture_density(const SceneLights::SkyPicture& picture, const Eigen::Vector3f& d) {
  const Eigen::Vector2f p = picture_position(picture, d);
  const int x = std::clamp(static_cast<int>(p.x()), 0, picture.width - 1);
  const int y = std::clamp(static_cast<int>(p.y()), 0, picture.height - 1);
  const auto row = static_cast<std::size_t>(y);
  const float row_share = picture.row_sums[row] - (y > 0 ? picture.row_sums[row - 1] : 0);
  const float* sums = picture.column_sums.data() + texel_index(picture, 0, y);
  const float share = row_share * (sums[x] - (x > 0 ? sums[x - 1] : 0));
  // Even in azimuth and in the cosine of the polar angle within a texel.
  return share / static_cast<float>(texel_solid_angle(picture, y));
}

Eigen::Vector3f draw_picture(const SceneLights::SkyPicture& picture, const Eigen::Vector2f& u) {
  const SumCell row = find_cell(picture.row_sums.data(), picture.height, u.y());
  const SumCell column = find_cell(picture.column_sums.data() + texel_index(picture, 0, row.index),
                                   picture.width, u.x());
  const float step = kPiF / static_cast<float>(picture.height);
  const float top = std::cos(step * static_cast<float>(row.index));
  const float bottom = std::cos(step * static_cast<float>(row.index + 1));
  const float z = top + row.fraction * (bottom - top);
  const float azimuth = kPiF * (2 * (static_cast<float>(column.index) + column.fraction) /
                                    static_cast<float>(picture.width) -
                                1);
  const float r = std::sqrt(std::max(0.0F, 1 - z * z));
  return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

Eigen::Vector3f beam_intensity(const SceneLights::Beam& beam, const Eigen::Vector3f& to) {
  const Eigen::Vector3f p = beam.projector_from_world * to;
  float x = 0, y = 0;
  if (beam.lens.model == LensModel::pinhole) {
    if (!(p.z() > 0)) return Eigen::Vector3f::Zero();
    x = static_cast<float>(beam.lens.fx_px) * p.x() / p.z() + static_cast<float>(beam.lens.cx_px);
    y = static_cast<float>(beam.lens.fy_px) * p.y() / p.z() + static_cast<float>(beam.lens.cy_px);
  } else {
    const auto pixel = project(beam.lens, p.cast<double>());
    if (!pixel) return Eigen::Vector3f::Zero();
    x = static_cast<float>(pixel->x());
    y = static_cast<float>(pixel->y());
  }
  const int w = beam.intensity.width(), h = beam.intensity.height();
  if (!(x > -0.5F && y > -0.5F && x < static_cast<float>(w) - 0.5F &&
        y < static_cast<float>(h) - 0.5F)) {
    return Eigen::Vector3f::Zero();
  }
  const float fx = std::floor(x), fy = std::floor(y);
  const float u = x - fx, v = y - fy;
  const int x0 = std::max(static_cast<int>(fx), 0), x1 = std::min(static_cast<int>(fx) + 1, w - 1);
  const int y0 = std::max(static_cast<int>(fy), 0), y1 = std::min(static_cast<int>(fy) + 1, h - 1);
  const auto at = [&](int px, int py) {
    const Rgbf& c = beam.intensity(px, py);
    return Eigen::Vector3f(c.r, c.g, c.b);
  };
  return (1 - v) * ((1 - u) * at(x0, y0) + u * at(x1, y0)) +
         v * ((1 - u) * at(x0, y1) + u * at(x1, y1));
}

Eigen::Vector3f sun_radiance(const SceneLights& lights, const Eigen::Vector3f& d) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const auto& sun : lights.suns) {
    if (hits_sun(sun, d)) sum += sun.radiance;
  }
  return sum;
}

bool hits_sun(const SceneLights::SunDisk& sun, const Eigen::Vector3f& direction) {
  // By the chord: a cosine in float does not tell a disk of a thousandth of a radian.
  return (direction - sun.to_sun).squaredNorm() < sun.chord * sun.chord;
}

float sun_density(const SceneLights::SunDisk& sun, const Eigen::Vector3f& direction) {
  return direction.dot(sun.to_sun) / (kPiF * sun.sin_radius * sun.sin_radius);
}

Eigen::Vector3f draw_sun(const SceneLights::SunDisk& sun, const Eigen::Vector2f& u) {
  const Eigen::Vector2f disk = sun.sin_radius * concentric_disk(u);
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
