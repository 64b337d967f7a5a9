#pragma once

#include <Eigen/Core>
#include <array>

#include "sim/render/microfacet.h"

namespace cousin {

/// Smooth-to-rough dielectric coat over a diffuse base. Directions are unit and in the surface's
/// frame, z along the normal, pointing away from the surface. Private to sim/render.
///
/// The coat reflects a share E(cos) of what comes from a direction: GGX microfacets, single
/// scattering, with Fresnel's equations [Walter et al. 2007; Heitz, JCGT 2018]. What it does not
/// reflect reaches the base and is weighted (1 - E(in)) (1 - E(out)) / (1 - average of E), which is
/// reciprocal and loses nothing at albedo 1 [Kelemen & Szirmay-Kalos 2001].
class Coat {
 public:
  Coat(double ior, double roughness);

  bool exists() const { return ior_ > 1; }
  /// E: share reflected by the coat of light from a direction `cosine` to the normal.
  float reflected(float cosine) const;
  /// 1 - E(out): share of the base's light that leaves along a direction.
  float leaving(float cosine) const { return 1 - reflected(cosine); }
  /// (1 - E(in)) / (1 - average): share of arriving light that lights the base; its cosine average
  /// is 1.
  float entering(float cosine) const { return leaving(cosine) * entering_scale_; }

  /// One direction drawn from the visible microfacet normals.
  struct Draw {
    Eigen::Vector3f in;
    float weight = 0;  ///< brdf * cosine / density
    float density = 0;
  };
  Draw draw(const Eigen::Vector3f& out, const Eigen::Vector2f& u) const;
  /// brdf times cosine of `in`, and the density `draw` has there; both per steradian.
  struct Value {
    float brdf_cosine = 0;
    float density = 0;
  };
  Value value(const Eigen::Vector3f& out, const Eigen::Vector3f& in) const;

 private:
  float fresnel(float cosine) const;

  static constexpr int kCells = 128;
  float ior_ = 1;
  Ggx facets_;
  float entering_scale_ = 1;
  std::array<float, kCells + 1> reflected_{};  ///< E at cosine = i / kCells
};

}  // namespace cousin
