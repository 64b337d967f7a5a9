#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "sim/render/infrared_pass.h"
#include "sim/truth/scene.h"

namespace cousin {

/// Lights and surfaces of a scene as the infrared pass uses them. Private to sim/render.
struct InfraredProjector {
  Eigen::Vector3f origin_m;  ///< less RayScene's centre
  Eigen::Matrix3f projector_from_world;
  Camera lens;
  bool is_pinhole = true;
  Image<float> intensity;

  /// Radiant intensity towards a point `offset_m` from the source, in world axes; 0 outside.
  float towards(const Eigen::Vector3f& offset_m) const;
};

struct InfraredLights {
  struct Sun {
    Eigen::Vector3f to_sun;
    float irradiance;
  };
  struct LampFace {  ///< lights as a point, throws shadows as a face
    Eigen::Vector3f origin_m, normal;
    Eigen::Vector3f axis_u_m, axis_v_m;  ///< from the centre to the middle of an edge
    float intensity;
  };
  /// Skies and environments: linear in the direction's height above the horizon, even below it.
  struct Dome {
    double zenith = 0, horizon = 0, ground = 0;
    double radiance(double up) const {
      return up >= 0 ? horizon + (zenith - horizon) * up : ground;
    }
  };
  std::vector<InfraredProjector> projectors;
  std::vector<Sun> suns;
  std::vector<LampFace> lamps;
  Dome dome;
  /// Irradiance of skies and environments on a surface whose normal has z = -1 .. 1.
  std::array<float, 65> ambient{};

  float ambient_at(float normal_z) const;
};
/// @param sample_rad  side of the square that a sample of the camera stands for: the projectors'
/// pictures are widened by it, so that a point's light is the square's where the surface faces
/// both.
InfraredLights make_infrared_lights(const Scene& scene, std::span<const Projector> projectors,
                                    const InfraredConfig& config, const Eigen::Vector3d& centre_m,
                                    double sample_rad);

/// What a material does with infrared light.
struct InfraredLook {
  float albedo = 0, transmittance = 0;
  float noise_ratio = 1;  ///< of the texture's other albedo to `albedo`
  double scale_m = 0;     ///< of the texture; 0 = none
  int octaves = 0;
  std::optional<SeedBoard> print;
  float ink_albedo = 0;
};

/// An instance at infrared, at any of its points.
struct InfraredSurface {
  std::vector<InfraredLook> looks;    ///< one a part of the model, or one for all
  Eigen::Matrix3f object_from_world;  ///< rotation, then the origin: for noise and print
  Eigen::Vector3f object_origin_m;

  struct Share {
    float albedo, transmittance;
  };
  Share at(const Eigen::Vector3f& position_m, std::uint16_t part, bool has_print) const;
};
std::vector<InfraredSurface> make_infrared_surfaces(const Scene& scene, double time_s,
                                                    const Eigen::Vector3d& centre_m);

}  // namespace cousin
