#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/truth/scene.h"

namespace cousin {

/// The scene's lights as the renderer uses them: float, positions less RayScene's centre. Lamps
/// shine but are not surfaces: they block no ray. Private to sim/render.
struct SceneLights {
  struct SunDisk {
    Eigen::Vector3f to_sun;
    float sin_radius = 0;  ///< of the angular radius
    float chord = 0;       ///< between unit directions to its centre and its edge
    Eigen::Vector3f irradiance;
    Eigen::Vector3f radiance;
  };
  struct LampFace {
    Eigen::Vector3f centre_m, axis_u_m, axis_v_m;
    Eigen::Vector3f normal;  ///< the side that shines
    float area_m2 = 0;
    Eigen::Vector3f radiance;
  };
  struct SkyDome {
    Eigen::Vector3f zenith, horizon, ground;
  };
  /// Radiance all around, by azimuth and polar angle about +z, bilinear between texel centres.
  struct SkyPicture {
    int width = 0, height = 0;
    std::vector<Eigen::Vector3f> radiance;
    // To draw directions, where the picture may hold small bright parts; empty = it does not.
    std::vector<float> row_sums;  ///< running sum over rows of luminance * solid angle, ends at 1
    std::vector<float> column_sums;  ///< the same along each row, ends at 1
  };
  /// Point source; `lens` without distortion is projected in float.
  struct Beam {
    Eigen::Matrix3f projector_from_world;
    Eigen::Vector3f origin_m;
    Camera lens;
    Image<Rgbf> intensity;
  };
  std::vector<SunDisk> suns;
  std::vector<LampFace> lamps;
  std::vector<SkyDome> skies;
  std::vector<SkyPicture> pictures;
  std::vector<Beam> beams;
};

/// A clear sky becomes a picture of 512 x 256 (0.7 degrees) and a sun.
/// @throws std::invalid_argument for a light that is not valid (scene_check.h), naming it.
SceneLights make_lights(const Scene& scene, const Eigen::Vector3d& centre_m);

/// Power heuristic: share of a sample drawn with density `own` where another way has `other`.
inline float share_of(float own, float other) {
  const float ratio = other / own;
  return 1 / (1 + ratio * ratio);
}

/// Radiance of the sky gradients along a unit direction.
Eigen::Vector3f dome_radiance(const SceneLights& lights, const Eigen::Vector3f& direction);
/// Radiance of all skies and pictures along a unit direction.
Eigen::Vector3f sky_radiance(const SceneLights& lights, const Eigen::Vector3f& direction);
/// Radiance of the suns' disks along a unit direction.
Eigen::Vector3f sun_radiance(const SceneLights& lights, const Eigen::Vector3f& direction);
/// Whether a unit direction meets the sun's disk.
bool hits_sun(const SceneLights::SunDisk& sun, const Eigen::Vector3f& direction);
/// Density, per steradian, with which draw_sun gives a direction of the disk.
float sun_density(const SceneLights::SunDisk& sun, const Eigen::Vector3f& direction);
/// Direction to a point of the sun's disk.
Eigen::Vector3f draw_sun(const SceneLights::SunDisk& sun, const Eigen::Vector2f& u);

/// Whether a ray meets a lamp's shining side before `far_m`: the density there, per steradian, of a
/// point drawn evenly on the lamp as seen from the origin; 0 = it does not.
float hit_lamp(const SceneLights::LampFace& lamp, const Eigen::Vector3f& origin_m,
               const Eigen::Vector3f& direction, float far_m);

/// A point drawn evenly on a lamp, seen from `from_m`. `density` 0: the lamp does not shine towards
/// it.
struct LampDraw {
  Eigen::Vector3f direction;
  float distance_m = 0;
  float density = 0;  ///< per steradian
};
LampDraw draw_lamp(const SceneLights::LampFace& lamp, const Eigen::Vector3f& from_m,
                   const Eigen::Vector2f& u);

/// Radiant intensity of a beam towards `to` (from its origin, in the world); zero outside its
/// picture.
Eigen::Vector3f beam_intensity(const SceneLights::Beam& beam, const Eigen::Vector3f& to);

/// Radiance of one picture along a unit direction.
Eigen::Vector3f picture_radiance(const SceneLights::SkyPicture& picture,
                                 const Eigen::Vector3f& direction);
/// Density, per steradian, with which draw_picture gives a direction.
float picture_density(const SceneLights::SkyPicture& picture, const Eigen::Vector3f& direction);
/// A direction drawn by luminance. @param picture  with sums.
Eigen::Vector3f draw_picture(const SceneLights::SkyPicture& picture, const Eigen::Vector2f& u);

}  // namespace cousin
