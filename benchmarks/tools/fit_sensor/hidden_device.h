#pragma once

#include <filesystem>
#include <vector>

#include "benchmarks/tools/fit_sensor/sensor_fit.h"
#include "sim/sensors/camera_sensor.h"

namespace cousin {

/// A simulated device whose numbers a fit is to find: the fast depth model with noise that follows
/// power laws of the distance exactly, and a raw camera.
struct HiddenDevice {
  ActiveStereoConfig config;  ///< its mode, steps, grain and bias; noise and fill are set a wall
  double spatial_px = 0.07;   ///< at 1 m
  double spatial_exponent = 0;
  double temporal_px = 0.03;  ///< at 1 m
  double temporal_exponent = 0.5;
  double half_fill_m = 6;  ///< fill = 1 / (1 + (Z / half_fill_m)^fill_power)
  double fill_power = 4;
  CameraSensorConfig camera;  ///< flat fields of its photosites
};

/// Numbers drawn over what users report of such cameras. @param rig  preset that it is one of
HiddenDevice draw_hidden_device(const std::string& rig, const Rng& rng);

/// How it is recorded.
struct RecordingPlan {
  std::vector<double> distances_m = {0.6, 0.85, 1.2, 1.7, 2.4, 3.2};
  int frames = 8;
  double tape_sigma_m = 0.002;  ///< stated distances are off by it
  double turn_rad = 0.09;       ///< of the wall about the vertical; half of it about the horizontal
  double bend_m = 0;            ///< of the wall, middle to the edge of the view, at every distance
  double noise_exponent = 2;    ///< 2: stereo. Another e makes sigma_Z grow as Z^e instead
  int flats = 6;
  double brightest = 0.8;  ///< of full well
};

double spatial_px_at(const HiddenDevice& device, double z_m);
double temporal_px_at(const HiddenDevice& device, double z_m);
double fill_at(const HiddenDevice& device, double z_m);

/// The recordings, in memory; frames are made when asked for.
RecordedFrames record(const HiddenDevice& device, const RecordingPlan& plan, const Rng& rng);
/// What reads them: the device's own mode.
DepthGeometry geometry_of(const HiddenDevice& device, const RecordingPlan& plan);
/// As a user's folder, with a recordings.toml.
void write_recordings(const std::filesystem::path& folder, const RecordedFrames& frames,
                      const HiddenDevice& device, const RecordingPlan& plan);

/// A number of the device, its estimate and interval.
struct HiddenParameter {
  std::string name, unit;
  double truth = 0;
  WithInterval estimate;
};
/// Every number that the fit states an interval of.
std::vector<HiddenParameter> hidden_parameters(const HiddenDevice& device, const SensorFit& fit);
bool is_inside(const HiddenParameter& parameter);

}  // namespace cousin
