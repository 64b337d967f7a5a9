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

/// `planes` floats of each Gaussian, in blocks of eight Gaussians: those of one plane are
/// neighbours, one vector, and all planes of a block lie together. A step that goes through the
/// Gaussians so reads memory in one stream: Adam on 330,000 Gaussians takes 8 ms, 21 where each
/// plane is a stream of its own. The last block is filled up with Gaussians that nothing shows.
class SplatPlanes {
 public:
  static constexpr int block = 8;

  SplatPlanes() = default;
  explicit SplatPlanes(int planes, int size = 0, float fill = 0);

  int size() const { return size_; }      ///< Gaussians
  int padded() const { return padded_; }  ///< with those that fill the last block
  int planes() const { return planes_; }
  float& at(int plane, int i) { return lanes(plane, i)[i % block]; }
  float at(int plane, int i) const { return lanes(plane, i)[i % block]; }
  /// Eight floats of one plane, aligned as a vector: of the block that holds Gaussian `i`.
  float* lanes(int plane, int i) { return values_[row(plane, i)].lane; }
  const float* lanes(int plane, int i) const { return values_[row(plane, i)].lane; }

  /// The Gaussians `source[0]`, `source[1]`, ... of this; an entry of -1 makes one filled with
  /// `fill`.
  SplatPlanes gathered(const std::vector<int>& source, float fill = 0) const;

  bool operator==(const SplatPlanes&) const = default;

 private:
  struct alignas(4 * block) Row {
    float lane[block];
    bool operator==(const Row&) const = default;
  };
  std::size_t row(int plane, int i) const {
    return static_cast<std::size_t>(i / block) * static_cast<std::size_t>(planes_) +
           static_cast<std::size_t>(plane);
  }
  int planes_ = 0;
  int size_ = 0;
  int padded_ = 0;
  std::vector<Row> values_;
};

/// Makes what lies beyond `size()` invisible.
void hide_padding(SplatPlanes& planes);
SplatPlanes to_planes(const std::vector<Splat>& splats);
std::vector<Splat> to_splats(const SplatPlanes& planes);

}  // namespace cousin
