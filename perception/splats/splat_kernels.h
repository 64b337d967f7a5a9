#pragma once

#include <cstdint>

#include "perception/splats/splat_camera.h"

namespace cousin {

/// A tile is 16 x 16 pixels: 8 rows of 4 blocks, each of 4 x 2 pixels, which are one vector.
struct SplatTile {
  static constexpr int side = 16;
  static constexpr int blocks = 32;
};

/// Constants of compositing [Kerbl et al. 2023].
struct SplatLimits {
  static constexpr float smallest_log2_alpha = -7.99435344F;  ///< log2(1/255)
  static constexpr float largest_alpha = 0.99F;
  static constexpr float least_transmittance = 1e-4F;
};

/// A Gaussian in one image: log2 of its alpha at (x + dx, y + dy) is
/// log2_opacity + across t^2 + down dy^2, where t = dx - tilt dy: the middle of its row dy is at
/// tilt dy. Both squares' factors are negative, so no rounding lets alpha exceed the opacity; of
/// the plain form a dx^2 + b dx dy + c dy^2 a needle whose centre is 1e4 px off leaves no digit.
struct ProjectedSplat {
  float x_px, y_px;
  float across, tilt, down;
  float log2_opacity;
  float color[3];
  float depth_m;
  float half_width_px, half_height_px;  ///< of the ellipse where alpha is 1/255
};

/// Sums over the pixels of one tile of what one Gaussian does to the loss, where g is alpha times
/// d loss / d alpha, (dx, dy) goes from its centre to the pixel, t as above, w is its weight.
struct SplatPartial {
  float g, g_t, g_dy, g_t2, g_t_dy, g_dy2;
  float weight, reserved;
  float color[3];  ///< w times d loss / d colour
  float padding;
};

struct ProjectTask {
  const SplatPlanes* planes = nullptr;
  SplatCamera camera;
  int sh_degree = 3;
  ProjectedSplat* projected = nullptr;   ///< one a Gaussian
  std::uint32_t* depth_order = nullptr;  ///< bits of the depth; all ones = not in the image
};

/// One view's tiles. Lists run front to back; `pair` numbers the (Gaussian, tile) pairs so that
/// those of one Gaussian are neighbours.
struct BlendTask {
  const ProjectedSplat* projected = nullptr;
  const std::uint32_t* tile_begin = nullptr;  ///< tiles + 1
  const std::uint32_t* tile_splat = nullptr;
  const std::uint32_t* tile_pair = nullptr;
  int tiles_across = 0;
  int width_px = 0, height_px = 0;
  float background[3]{};
  float* color[3]{};               ///< rows of the whole image
  float* transmittance = nullptr;  ///< likewise
  float* depth_m = nullptr;        ///< may be null, together with mean_depth_m
  float* mean_depth_m = nullptr;   ///< likewise
  /// With depth_m: two of each Gaussian, change of its depth a pixel to the right and down, as a
  /// share of the depth.
  const float* depth_slope = nullptr;
  std::uint32_t* tile_done = nullptr;  ///< entries of the list that were looked at
  std::uint32_t* touched = nullptr;    ///< of those entries: blocks that the ellipse may meet
};

struct BlendGradientTask {
  BlendTask blend;  ///< as it was run
  const float* color_gradient[3]{};
  SplatPartial* partials = nullptr;  ///< one a pair
};

/// Adam's constants for one group of parameters at one step, bias corrections included:
/// p -= rate m / (scale sqrt(v) + epsilon).
struct AdamRate {
  float rate = 0;
  float scale = 1;
};

struct UpdateTask {
  SplatPlanes* planes = nullptr;
  SplatCamera camera;
  int sh_degree = 3;
  const ProjectedSplat* projected = nullptr;
  const SplatPartial* partials = nullptr;
  const std::uint32_t* pair_first = nullptr;  ///< of each Gaussian
  const std::uint32_t* pair_count = nullptr;  ///< 0: left as it is, but for pulls

  SplatPlanes* gradients = nullptr;  ///< if given they are written, and nothing else is done
  SplatPlanes* first_moment = nullptr;
  SplatPlanes* second_moment = nullptr;
  AdamRate centre, log_scale, rotation, opacity, dc, rest;
  bool with_rest = true;  ///< else the coefficients beyond dc stay as they are
  float beta1 = 0.9F, beta2 = 0.999F, epsilon = 1e-15F;
  float opacity_pull = 0;  ///< added to d loss / d opacity (not its logit), of all, seen or not
  float scale_pull = 0;    ///< added to d loss / d scale in metres, of all
  float* gradient_sum = nullptr;  ///< += |d loss / d centre in the image|, of width and height 2
  bool by_tile = false;  ///< the sum takes magnitudes tile by tile: pulls apart do not cancel
  float* gradient_count = nullptr;  ///< += 1
};

/// The inner loops, for one instruction set. Ranges of Gaussians begin and end at multiples of 8.
struct SplatKernels {
  const char* name;
  void (*project)(const ProjectTask& task, int first, int last);
  void (*blend)(const BlendTask& task, int tile);
  void (*blend_gradient)(const BlendGradientTask& task, int tile);
  void (*update)(const UpdateTask& task, int first, int last);
};

const SplatKernels& portable_splat_kernels();
const SplatKernels* avx2_splat_kernels();  ///< null where this machine or build has no AVX2 and FMA
const SplatKernels& best_splat_kernels();

}  // namespace cousin
