#pragma once

#include <cstddef>

namespace cousin::photometric {

/// Private to perception/splats: one channel's rows [begin, end) of the photometric loss. Plain
/// pointers, so that a kernel's translation unit, built for wider registers than the rest, makes no
/// function that others could link.
struct Band {
  const float* rendered = nullptr;    ///< whole channel, row by row
  const float* photograph = nullptr;  ///< whole channel
  const float* weight = nullptr;      ///< whole image, or null: all 1
  float* gradient = nullptr;          ///< whole channel; rows [begin, end) are written
  double* row_l1 = nullptr;           ///< of each row of the image: weighted sum of |difference|
  double* row_ssim = nullptr;         ///< of each row of the image: weighted sum of similarities
  float* scratch = nullptr;           ///< scratch_floats(width)
  int width = 0, height = 0;
  int begin = 0, end = 0;
  float taps[6] = {};    ///< of the window along one axis: the middle, then one to five pixels away
  float l1_scale = 0;    ///< gradient of the value with respect to one |difference|
  float ssim_scale = 0;  ///< gradient of the value with respect to one similarity
};
using BandKernel = void (*)(const Band& band);

inline constexpr int kReach = 5;        ///< of the window, to each side
inline constexpr int kRing = 11;        ///< rows that one output row needs
inline constexpr int kLanes = 8;        ///< pixels a step
inline constexpr int kWindowed = 4;     ///< rendered, photograph, sum of their squares, product
inline constexpr int kDerivatives = 3;  ///< with respect to mean, squares, product

/// Floats between rows of the scratch: eight zeros on each side, whole vectors between.
constexpr std::size_t row_stride(int width) {
  return static_cast<std::size_t>((width + kLanes - 1) / kLanes * kLanes + 2 * kLanes);
}
constexpr std::size_t scratch_floats(int width) {
  return row_stride(width) * ((kRing + 1) * (kWindowed + kDerivatives));
}

void loss_band_portable(const Band& band);
/// Null where this machine has no AVX2 and FMA, or the program was not built for x86-64.
BandKernel loss_band_avx2();

}  // namespace cousin::photometric
