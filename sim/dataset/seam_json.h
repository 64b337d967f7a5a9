#pragma once

#include <string>
#include <string_view>

#include "sim/dataset/seam_io.h"
#include "sim/types/seams.h"

namespace cousin {

/// Private to sim/dataset: the JSON seams as text; the schemas are in seam_json.cpp,
/// seam_masks.cpp, seam_detections.cpp, seam_fits.cpp and seam_tracks.cpp. Readers take the text
/// and the name that errors show. @throws std::runtime_error naming file, key, value and limit.

std::string corners_to_json(const Corners& corners);
Corners corners_from_json(std::string_view text, const std::string& name);
std::string poses_to_json(const Poses& poses);
Poses poses_from_json(std::string_view text, const std::string& name);
std::string traits_to_json(const Traits& traits);
Traits traits_from_json(std::string_view text, const std::string& name);
std::string timings_to_json(const std::vector<StageTiming>& timings);
std::vector<StageTiming> timings_from_json(std::string_view text, const std::string& name);
std::string silhouettes_to_json(const Silhouettes& silhouettes, int scene_index);
Silhouettes silhouettes_from_json(std::string_view text, const std::string& name,
                                  const MaskImages& images = {});
std::string boxes_to_json(const Boxes& boxes, int scene_index);
Boxes boxes_from_json(std::string_view text, const std::string& name,
                      const DetectionImages& images = {});
std::string keypoints_to_json(const Keypoints& keypoints, int scene_index);
Keypoints keypoints_from_json(std::string_view text, const std::string& name,
                              const DetectionImages& images = {});
std::string fits_to_json(const Fits& fits);
Fits fits_from_json(std::string_view text, const std::string& name);
std::string tracks_to_json(const Tracks& tracks);
Tracks tracks_from_json(std::string_view text, const std::string& name);

}  // namespace cousin
