#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cousin {

/// A scene whose radiance is known in closed form, and what the path tracer made of it.
struct ClosedForm {
  std::string name;
  double truth = 0;
  double estimate = 0;        ///< mean over the image
  double standard_error = 0;  ///< of the estimate, by its own samples
  std::int64_t samples = 0;
  /// Within the 99 % interval of the estimate; 2e-5 of it is left to rounding in float.
  bool agrees = false;
};

/// Furnaces (a white body of each material and roughness under an even sky of radiance 1 cannot be
/// seen), a Lambert sphere in the sun, the form factor of an area light, a mirror under a sky that
/// brightens with height, a thin leaf from above and below, a beam's inverse square, a sphere that
/// lights itself inside, an environment picture with a small bright part; a floor under water in
/// sky and sun, flesh that is white, deep or a thin layer.
/// @param samples  of each scene, at least 1024.
std::vector<ClosedForm> closed_forms(std::int64_t samples, std::uint64_t seed);

}  // namespace cousin
