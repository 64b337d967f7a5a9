#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/tools/fit_sensor/depth_law.h"
#include "benchmarks/tools/fit_sensor/photon_transfer_fit.h"
#include "benchmarks/tools/fit_sensor/recordings.h"
#include "benchmarks/tools/fit_sensor/rig_choice.h"

namespace cousin {

/// What recordings say of a rig, and the preset that follows.
struct SensorFit {
  std::string rig;
  std::string data;  ///< what it is fitted to, in words
  DepthGeometry geometry;
  std::optional<DepthFit> depth;
  std::optional<GainFit> gain;
  std::vector<std::string> problems;  ///< of both; not empty: rejected, there is no preset
  std::string preset_toml;
};

/// Frames as recordings name them, or as a simulated device makes them.
struct RecordedFrames {
  std::vector<WallFrames> walls;
  std::optional<FlatFrames> dark;
  std::vector<FlatFrames> flats;
  int max_code = 255;  ///< of the raw frames
};

/// Reads, measures, fits. @param progress  (what, done, all)
/// @throws std::runtime_error naming folder or file, value and limit: too few walls or frames (with
/// how many are needed), unequal sizes, a mode that the rig lacks.
SensorFit fit_sensor(const Recordings& recordings, const RigChoice& rig,
                     const std::function<void(const std::string&, int, int)>& progress = {});

/// The same of frames at hand.
SensorFit fit_frames(const RecordedFrames& frames, const DepthGeometry& geometry,
                     const RigChoice& rig, const std::string& data,
                     const std::function<void(const std::string&, int, int)>& progress = {});

/// How a rig's depth images of that size follow from disparities, by the preset and what the
/// recordings override.
/// @throws std::runtime_error listing the modes' sizes if neither knows the focal length, or if the
/// region leaves the image.
DepthGeometry depth_geometry(const Recordings& recordings, const RigChoice& rig, int width_px,
                             int height_px);

}  // namespace cousin
