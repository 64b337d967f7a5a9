#pragma once

#include <map>
#include <vector>

#include "perception/pipelines/estimate.h"

namespace cousin {

/// A box of the first sensor, to whose image depth is aligned, and what is seen in it.
struct SeenBox {
  const DetectedBox* box = nullptr;
  const SensorFrame* image = nullptr;
  const FrameDepth* depth = nullptr;  ///< its image is empty where the estimate has no depth
};

/// The boxes of the first sensor, in their order; of `capture` and `so_far`, which must outlive
/// them.
/// @param stage  who asks
/// @throws StageError naming a box of a frame that the capture has not
std::vector<SeenBox> seen_boxes(const Capture& capture, const Estimate& so_far, const char* stage);

/// Fits by the id of their box. @param fits  must outlive them
std::map<int, const ObjectFit*> fits_by_box(const Fits& fits);

}  // namespace cousin
