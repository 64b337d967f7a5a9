#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

#include "sim/dataset/json_interop.h"
#include "sim/dataset/mask_codes.h"

namespace cousin {

/// Private to sim/dataset: what the seams share that are lists of COCO results. All throw
/// std::runtime_error naming file, key, value and limit.

inline constexpr std::int64_t kFramesPerScene = 1'000'000;
inline constexpr std::size_t kMaxOutlinePoints = 1'000'000;
inline constexpr double kMaxCocoPixel = 1e6;

/// image_id = 1,000,000 scene + frame.
struct CocoImage {
  int scene = 0;
  int frame = 0;
};
/// @param wanted  the scene that entries must be of; -1: any, but all of one
/// @param first  in and out: of the first entry; -1 before it
CocoImage image_of(const JsonNode& image_id, int wanted, std::int64_t& first);
/// @throws std::invalid_argument where the scene has no such id
std::int64_t image_id_of(int scene_index, int frame);

/// {"size": [height, width], "counts": "compressed text" or [runs]}.
/// @param image_px  in: width and height that it must be of, (0, 0) = any; out: its own
PlacedMask mask_of_runs(const JsonNode& node, Eigen::Vector2i& image_px);
/// Several polygons are one mask. Without a word on the image it ends where they end.
PlacedMask mask_of_polygons(const JsonNode& node, const Eigen::Vector2i& image_px);

}  // namespace cousin
