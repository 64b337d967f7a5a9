#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/types/camera.h"
#include "sim/types/image.h"
#include "sim/types/mosaic.h"
#include "sim/types/pose.h"

namespace cousin {

enum class Shutter { global, rolling };

/// One sensor of a rig, as the device reports it. Truth may differ.
struct SensorReport {
  std::string name = "rgb";  ///< also its folder in a dataset
  Camera camera;             ///< nominal; a frame may report its own
  Pose sensor_from_rig;
  double exposure_s = 0;  ///< 0: unknown
  Shutter shutter = Shutter::global;
  double readout_s = 0;     ///< first to last row; 0 for a global shutter
  bool linear_raw = false;  ///< 16-bit linear images are handed over too
  RawFormat raw_format;     ///< of those
};

/// A sensor of this name hands over depth alone, in its own pixels; its folder is depth/.
inline constexpr std::string_view kDepthSensor = "depth";

/// What one sensor hands over at one instant. Images that a sensor does not give stay empty.
struct SensorFrame {
  Camera reported;             ///< this image's calibration (autofocus changes it per image)
  Image<Rgb8> color;           ///< 8-bit sRGB
  Image<std::uint8_t> grey;    ///< 8-bit, linear in light: of an infrared imager, without colour
  Image<std::uint16_t> raw;    ///< linear, as SensorReport::raw_format says
  Image<std::uint16_t> depth;  ///< times depth_unit_m = metres along the axis; 0 = none
  double depth_unit_m = 0.001;
  std::optional<double> time_s;  ///< of its first row, by the device's clock; else the frame's
};

struct Frame {
  int id = 0;
  double time_s = 0;
  std::optional<Pose> rig_from_world;  ///< only if the rig knows it (arm, turntable)
  std::vector<SensorFrame> sensors;    ///< one for each sensor of the rig, same order
};

/// What a rig hands over; real and simulated captures are the same type. No truth.
struct Capture {
  std::string pipeline;  ///< name of the pipeline made for it; empty for a real capture
  std::string board;  ///< calibration object in view: "markers", "plain", "none"; empty = unknown
  std::vector<SensorReport> rig;
  std::vector<Frame> frames;
  std::vector<std::string> warnings;  ///< what a reader skipped and why
};

}  // namespace cousin
