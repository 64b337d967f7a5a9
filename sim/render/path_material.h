#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "sim/render/coat.h"
#include "sim/render/microfacet.h"
#include "sim/truth/scene.h"

namespace cousin {

/// A material as the path tracer uses it: colours as vectors, tables of what microfacets reflect.
/// Private to sim/render.
struct PathMaterial {
  /// @throws std::invalid_argument naming the material, the value and the limit.
  explicit PathMaterial(const Material& material);

  SurfaceKind kind;
  Coat coat;
  Ggx facets;
  float ior;
  Eigen::Vector3f albedo, back_albedo, transmittance, ink_albedo;
  Eigen::Vector3f mean_free_path_m;  ///< zero: light leaves where it came
  std::optional<SeedBoard> print;
  std::optional<NoiseTexture> noise;
  /// Metal: share of light that single scattering by perfectly reflecting facets returns, at cosine
  /// = (i / 128)^2. Glass: share that it reflects or lets through, from outside and from inside.
  /// Finer where light grazes.
  static constexpr int kCells = 128;
  std::array<float, kCells + 1> kept_outside{}, kept_inside{};
};

/// Fresnel's share for light that comes at `cosine` > 0 to a medium of relative index `eta`.
float fresnel(float cosine, float eta);

/// What one point of a surface does to light. Directions are unit and in the point's frame, z along
/// the shading normal on the side that `out` is on.
struct PathBsdf {
  const PathMaterial* material = nullptr;
  Eigen::Vector3f out;     ///< where the ray came from; z > 0
  bool is_inside = false;  ///< glass: `out` is in it
  Eigen::Vector3f albedo;  ///< of the side that `out` is on
  /// Where light leaves the base elsewhere than it came (subsurface.h), its coat and its base are
  /// at two points, each of which gives and draws its own part, with the probabilities of both.
  enum class Part { whole, coat, base };
  Part part = Part::whole;
  Eigen::Vector3f came_out = Eigen::Vector3f::Zero();  ///< base: takes the place of `albedo`

  struct Value {
    Eigen::Vector3f bsdf_cosine = Eigen::Vector3f::Zero();  ///< per steradian
    float density = 0;  ///< of `draw` there, per steradian; 0 also where it is infinite
  };
  Value value(const Eigen::Vector3f& in) const;

  struct Draw {
    Eigen::Vector3f in;
    Eigen::Vector3f weight = Eigen::Vector3f::Zero();  ///< bsdf * cosine / density; zero = absorbed
    float density = 0;
    bool is_sharp = false;  ///< the one direction of smooth glass: infinite density
  };
  /// @param lobe  in [0, 1): which of coat, reflection and transmission.
  Draw draw(const Eigen::Vector2f& u, float lobe) const;
  /// Clear: one of its two ways, weighed by Fresnel's share.
  Draw clear_way(bool reflects) const;

 private:
  struct Lobes {
    float coat = 0, reflect = 0, transmit = 0;  ///< probabilities; their sum is 1, or 0
  };
  Lobes lobes() const;
  Value metal(const Eigen::Vector3f& in) const;
  Value glass(const Eigen::Vector3f& in) const;
  Draw draw_metal(const Eigen::Vector2f& u) const;
  Draw draw_glass(const Eigen::Vector2f& u, float lobe) const;
  Draw draw_clear(float lobe) const;
};

}  // namespace cousin
