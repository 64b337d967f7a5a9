#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "sim/types/image.h"

namespace cousin {

/// Matching costs of a rectified pair: for pixel (x, y) of the left image and candidate i the
/// distance to pixel (x - first_disparity - i, y) of the right one, `stride` bytes a pixel. Private
/// to sim/imaging.
class CostVolume {
 public:
  CostVolume(int width, int height, int candidates, int first_disparity_px);

  int width() const { return width_; }
  int height() const { return height_; }
  int candidates() const { return candidates_; }
  int first_disparity_px() const { return first_disparity_px_; }
  int stride() const { return stride_; }  ///< candidates, rounded up to whole vectors
  int shift() const { return shift_; }    ///< costs are sums of distances >> shift
  void set_shift(int shift) { shift_ = shift; }
  std::uint8_t* row(int y) { return costs_.get() + offset(y); }
  const std::uint8_t* row(int y) const { return costs_.get() + offset(y); }

 private:
  std::size_t offset(int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) *
           static_cast<std::size_t>(stride_);
  }
  int width_, height_, candidates_, first_disparity_px_, stride_;
  int shift_ = 0;
  std::unique_ptr<std::uint8_t[]> costs_;  ///< uninitialised: every byte is written
};

/// Hamming distances of census codes summed over block_px x block_px pixels, divided by a power of
/// two if they would not fit a byte (`shift`). Candidates outside the right image cost the most
/// there is.
/// @param bits  largest distance of two codes.
CostVolume hamming_costs(const Image<std::uint64_t>& left, const Image<std::uint64_t>& right,
                         int bits, int block_px, int candidates, int first_disparity_px);

/// Sums over `paths` (4 or 8) directions of the path costs L_r of Hirschmueller [TPAMI 2008, eq.
/// 13], same layout as the costs. Two parts that are to be added, as they are made side by side.
struct PathSums {
  std::unique_ptr<std::uint16_t[]> part[2];
};
PathSums sum_paths(const CostVolume& costs, int paths, std::uint16_t p1, std::uint16_t p2);

}  // namespace cousin
