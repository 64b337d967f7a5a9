#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/loop/plan.h"

namespace cousin {

/// A picture that a rig hands over with each view.
struct PlannedPicture {
  std::string name;  ///< as its folder in a dataset
  int width_px = 0;
  int height_px = 0;
  double bytes = 0;  ///< of its file, by a typical share of PNG
};
/// In the order of the rig's sensors.
std::vector<PlannedPicture> planned_pictures(const DeviceConfig& rig, const Streams& streams);

/// What `cousin render` would do with a configured scene.
struct RenderPlan {
  int scenes = 1;
  int views = 0;                         ///< that this call renders, of all scenes
  int views_of_all = 0;                  ///< differs from `views` for a shard
  std::vector<PlannedPicture> pictures;  ///< of each view
  double picture_bytes = 0;              ///< of all views, truth images apart
  std::filesystem::path dataset;
  std::vector<PlanEntry> passes;
};
/// @param truth  images of the truth that are written  @param views  of this shard
RenderPlan render_plan(const RunConfig& config, const TruthNeeds& truth, int scenes, int views,
                       const std::filesystem::path& dataset);

/// Lines for people: what is rendered and written, what runs, what is left out and why.
std::string describe(const RenderPlan& plan);
/// The same as a JSON object.
std::string to_json(const RenderPlan& plan);

}  // namespace cousin
