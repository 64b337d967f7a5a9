#pragma once

#include <vector>

#include "perception/splats/splat_render.h"
#include "perception/splats/tile_lists.h"

namespace cousin {

/// Everything between the parameters of Gaussians and one image of them. Its buffers grow and are
/// used again: a trainer keeps one.
struct SplatFrame {
  SplatCamera camera;
  int sh_degree = 3;
  std::vector<ProjectedSplat> projected;
  std::vector<std::uint32_t> depth_order;
  TileLists lists;
  std::size_t most_pairs = kMostPairs;  ///< of `lists`
  ColorPlanes color;                    ///< over the background
  Image<float> transmittance;           ///< left at each pixel
  Image<float> depth_m, mean_depth_m;   ///< if asked for, as in SplatImage
  std::vector<float> depth_slope;       ///< with them, see BlendTask
  std::vector<std::uint32_t> tile_done, touched;
  std::vector<SplatPartial> partials;  ///< of blend_gradients
};

enum class SplatDepths { none, with };

/// Projects, sorts and composites. Bytes do not depend on the number of threads.
/// @throws TooManyPairs
void draw_splats(const SplatKernels& kernels, const SplatPlanes& planes, int sh_degree,
                 const SplatCamera& camera, const std::array<float, 3>& background,
                 SplatDepths depths, SplatFrame& frame);

/// The frame drawn last, as the kernels take it: tile by tile.
BlendTask blend_task(SplatFrame& frame, const std::array<float, 3>& background);

/// Fills `partials` from d loss / d colour of the frame drawn last. @param background  as drawn
void blend_gradients(const SplatKernels& kernels, const ColorPlanes& color_gradient,
                     const std::array<float, 3>& background, SplatFrame& frame);

/// d loss / d parameters after `blend_gradients`; 0 for what the image does not show.
SplatPlanes parameter_gradients(const SplatKernels& kernels, const SplatPlanes& planes,
                                const SplatFrame& frame);

}  // namespace cousin
