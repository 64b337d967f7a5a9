#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "sim/dataset/camera_pair.h"
#include "sim/dataset/depth_keys.h"

namespace cousin {

/// Private to sim/dataset: cameras of a colour and depth capture, and what its depth means.
struct RgbdCameras {
  Camera color;
  std::optional<Camera> depth;  ///< none: depth is in the colour image's pixels
  Pose depth_from_color;
  bool says_aligned = false;  ///< the file itself says where depth's pixels are
  DepthKeys depth_keys;
};

/// Of the text of a file:
///   JSON or YAML of one camera, of both (camera_pair.h), or BoofCV's visual_depth, with the keys
///   of depth_keys.h;
///   a rig.json of ours; Kalibr's camchain of two cameras; ".txt": a 3 x 3 or 4 x 4 matrix.
/// @throws std::runtime_error naming `name`, key, value and limit.
RgbdCameras rgbd_cameras_of_text(std::string_view text, const std::string& name,
                                 const PairSizes& sizes, std::optional<double> length_unit_m);

/// Of `intrinsics`, a file or "fx,fy,cx,cy[,k1,k2,p1,p2,k3]"; "" = the folder's intrinsics.json or
/// another file of a usual name, or color.yaml and depth.yaml.
RgbdCameras rgbd_cameras(const std::filesystem::path& folder, const std::string& intrinsics,
                         const PairSizes& sizes, std::optional<double> length_unit_m);

}  // namespace cousin
