#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/types/capture.h"

namespace cousin {

/// Private to sim/dataset: rig.json and scene_camera.json as text; the schemas are in
/// capture_io.cpp.

enum class ImageKind { color, grey, raw, depth };
/// Which images of one sensor a frame has.
struct ImageKinds {
  bool color = false;
  bool grey = false;
  bool raw = false;
  bool depth = false;
  bool depth_if_there = false;   ///< another program's files, which do not list their images
  bool depth_has_scale = false;  ///< such files say what a unit of depth is
};

/// Place of the sensor named kDepthSensor; the rig's size if it has none.
std::size_t depth_sensor(const std::vector<SensorReport>& rig);
/// Folder of a sensor's images below the scene: its name for colour and grey, raw/ and depth/ for
/// the first sensor's others and NAME_raw/ and NAME_depth/ for those of the rest. A sensor named
/// "depth" has its depth in depth/, whatever its place, and then the first has none there.
std::string image_folder(const std::vector<SensorReport>& rig, std::size_t sensor, ImageKind kind);
/// @throws std::invalid_argument if the rig is empty, a name is not of 1 to 64 of a-z 0-9 _, or two
/// folders coincide.
void check_rig(const std::vector<SensorReport>& rig);

std::string rig_to_json(const Capture& capture);
/// `kinds`: which images each sensor of each frame has on disk.
std::string scene_camera_to_json(const Capture& capture,
                                 const std::vector<std::vector<ImageKinds>>& kinds);
/// All but the frames. @throws std::runtime_error naming `name` and the key.
Capture rig_from_json(std::string_view text, const std::string& name);
/// Fills capture.frames without images, for the rig that is already there; says which images each
/// sensor of each frame has.
std::vector<std::vector<ImageKinds>> frames_from_json(std::string_view text,
                                                      const std::string& name, Capture& capture);

}  // namespace cousin
