#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "perception/sfm/sfm_poses.h"
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

/// Photographs without poses, as structure from motion places them.
struct PlacedSet {
  SfmStatus status = SfmStatus::not_built;
  std::string reason;  ///< unless ok: what and why
  int photographs = 0, placed = 0;
  StageTiming seconds;  ///< of structure from motion
  PosedSet set;  ///< every eighth of the placed views is held out; empty where none has a pose
};
/// A folder of photographs of one lens (see import_folder): COLMAP matches them all with each
/// other, our adjustment refines, Gaussians begin at its points. Views that are held out have had
/// their part in the poses, as is usual. @throws as read_split_set
PlacedSet place_photographs(const std::filesystem::path& folder, const std::string& intrinsics);

}  // namespace cousin
