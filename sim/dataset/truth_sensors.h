#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/truth/scene.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// Private to sim/dataset: truth of what sensors beside the first see, below truth/sensors/NAME/:
/// scene_gt.json, scene_gt_info.json, keypoints.json without models, and image folders, all as
/// those of the first sensor below truth/.

/// "sensors/NAME", below truth/; empty for an empty name, which is the first sensor's.
std::filesystem::path sensor_folder(const std::string& sensor);

/// The JSON files of a sensor whose images are there.
void write_sensor_labels(const std::filesystem::path& truth_dir, const Scene& scene,
                         const SensorViews& sensor);
/// Visibility and keypoints of each view into `sensor.images`, if the files are there.
/// @throws std::runtime_error naming file, key, value and limit.
void read_sensor_labels(const std::filesystem::path& truth_dir, const Scene& scene,
                        SensorViews& sensor);

}  // namespace cousin
