#pragma once

#include <filesystem>
#include <vector>

#include "perception/splats/splat_model.h"
#include "perception/splats/splat_views.h"

namespace cousin {

/// Photographs with known poses, some of them held out.
struct PosedSet {
  std::vector<SplatView> train, test;
  SplatModel start;  ///< what Gaussians begin from
};

/// A folder with transforms.json, points.ply and split.txt: a line "FILE train" or "FILE test" for
/// each view. @throws std::runtime_error naming file, value and limit, or if one part is empty.
PosedSet read_split_set(const std::filesystem::path& folder);

/// A transforms.json: every eighth view is held out, as the splatting literature does [Barron et
/// al., CVPR 2022]. Gaussians begin at `points` places drawn evenly over a cube of twice the
/// cameras' median distance about the point that they look at. @param largest_side_px
/// photographs are made this small. @throws as read_split_set.
PosedSet read_every_eighth(const std::filesystem::path& transforms_json, int largest_side_px,
                           int points, std::uint64_t seed);

}  // namespace cousin
