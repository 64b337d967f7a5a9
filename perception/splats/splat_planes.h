#pragma once

#include <cstddef>
#include <vector>

#include "perception/splats/splat_model.h"

namespace cousin {

/// Where each parameter of a Gaussian lies among the planes of `SplatPlanes`.
struct SplatPlane {
  static constexpr int centre = 0;     ///< 3, metres from the origin
  static constexpr int log_scale = 3;  ///< 3
  static constexpr int rotation = 6;   ///< 4, w x y z
  static constexpr int opacity = 10;   ///< logit
  static constexpr int dc = 11;        ///< 3
  static constexpr int rest = 14;      ///< 15 of red, 15 of green, 15 of blue
  static constexpr int count = 59;
};

/// One plane of floats for every parameter: eight neighbours of a plane are one vector. Planes end
/// in Gaussians that nothing shows, up to a multiple of eight.
class SplatPlanes {
 public:
  SplatPlanes() = default;
  explicit SplatPlanes(int planes, int size = 0, float fill = 0);

  int size() const { return size_; }      ///< Gaussians
  int padded() const { return padded_; }  ///< floats a plane
  float* plane(int k) { return values_.data() + static_cast<std::size_t>(k) * stride(); }
  const float* plane(int k) const {
    return values_.data() + static_cast<std::size_t>(k) * stride();
  }
  int planes() const { return planes_; }

  /// The Gaussians `source[0]`, `source[1]`, ... of this; an entry of -1 makes one filled with
  /// `fill`.
  SplatPlanes gathered(const std::vector<int>& source, float fill = 0) const;

  bool operator==(const SplatPlanes&) const = default;

 private:
  std::size_t stride() const { return static_cast<std::size_t>(padded_); }
  int planes_ = 0;
  int size_ = 0;
  int padded_ = 0;
  std::vector<float> values_;
};

/// Makes what lies beyond `size()` invisible.
void hide_padding(SplatPlanes& planes);
SplatPlanes to_planes(const std::vector<Splat>& splats);
std::vector<Splat> to_splats(const SplatPlanes& planes);

}  // namespace cousin
