#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/render/infrared_light.h"
#include "sim/render/ray_scene_impl.h"

namespace cousin {

/// Where a ray met a surface. Private to sim/render.
struct InfraredHit {
  Eigen::Vector3f position_m;
  Eigen::Vector3f normal;  ///< of the face, towards where the ray came from
  float offset_m = 0;      ///< how far off the surface rays must start
  int surface = -1;        ///< into the scene's instances
  InfraredSurface::Share share;
};

/// Samples of one packet and what comes back.
struct InfraredSamples {
  LaneMask mask;
  Eigen::Vector3f origin_m;
  Eigen::Vector3f direction[kLanes];
  Eigen::Vector2f sky[kLanes];        ///< a point of the square: where its sky ray goes
  Eigen::Vector2f lamp[kLanes];       ///< and its rays to lamps
  float steady[kLanes];               ///< radiance by suns and lamps
  float ambient[kLanes];              ///< by skies if nothing hid them
  float asked[kLanes], open[kLanes];  ///< see SkyPixel
  float projected[kLanes];            ///< and by projectors
  bool met[kLanes];                   ///< a surface
  InfraredHit hit[kLanes];
};

/// Traces packets of camera rays and the shadow rays of all lights.
class InfraredShader {
 public:
  /// Keeps references.
  InfraredShader(const RayScene::Impl& impl, const InfraredLights& lights,
                 const std::vector<InfraredSurface>& surfaces);
  /// Fills what comes back.
  void operator()(InfraredSamples& samples);

 private:
  void add_projector(InfraredSamples& samples, const InfraredProjector& projector);
  void add_sun(InfraredSamples& samples, const InfraredLights::Sun& sun);
  void add_lamp(InfraredSamples& samples, const InfraredLights::LampFace& lamp);
  void add_sky(InfraredSamples& samples);
  void aim(const InfraredHit& hit, int lane, const Eigen::Vector3f& direction, float far_m,
           float light);
  void add_unblocked(RTCIntersectContext& context, float* radiance);

  const RayScene::Impl& impl_;
  const InfraredLights& lights_;
  const std::vector<InfraredSurface>& surfaces_;
  RTCIntersectContext coherent_, incoherent_;
  HitPacket camera_;
  ShadowPacket shadow_;
  LaneMask mask_;
  float light_[kLanes];
};

}  // namespace cousin
