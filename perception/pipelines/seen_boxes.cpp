#include "perception/pipelines/seen_boxes.h"

#include <string>

namespace cousin {

std::vector<SeenBox> seen_boxes(const Capture& capture, const Estimate& so_far, const char* stage) {
  static const FrameDepth kNone;
  std::map<int, std::size_t> places;
  for (std::size_t i = 0; i < capture.frames.size(); ++i) places[capture.frames[i].id] = i;
  std::vector<SeenBox> seen;
  for (const DetectedBox& box : so_far.boxes) {
    if (box.sensor != 0) continue;
    const auto place = places.find(box.frame);
    if (place == places.end())
      throw StageError(stage, "box " + std::to_string(box.id) + " is of frame " +
                                  std::to_string(box.frame) + ", which the capture has not");
    seen.push_back({&box, &capture.frames[place->second].sensors.front(),
                    so_far.depths.empty() ? &kNone : &so_far.depths[place->second]});
  }
  return seen;
}

std::map<int, const ObjectFit*> fits_by_box(const Fits& fits) {
  std::map<int, const ObjectFit*> of_box;
  for (const ObjectFit& fit : fits) of_box[fit.instance] = &fit;
  return of_box;
}

}  // namespace cousin
