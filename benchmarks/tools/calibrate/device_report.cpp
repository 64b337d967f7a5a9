#include "benchmarks/tools/calibrate/device_report.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

namespace cousin {

void compare_with_reported(CalibrationRun& run) {
  const auto& names = run.photos.cameras;
  const auto depth = std::find(names.begin(), names.end(), "ir_left");
  if (depth == names.end() || run.photos.reported.size() != names.size()) return;
  const auto d = static_cast<std::size_t>(depth - names.begin());
  std::vector<bool> colored(names.size(), false);
  for (const CalibrationPhoto& photo : run.photos.photos) {
    if (!photo.is_linear_grey) colored[static_cast<std::size_t>(photo.camera)] = true;
  }
  const auto color = std::find(colored.begin(), colored.end(), true);
  if (color == colored.end()) return;
  const auto c = static_cast<std::size_t>(color - colored.begin());
  const SensorReport &of_depth = run.photos.reported[d], &of_color = run.photos.reported[c];
  if (of_depth.camera.width_px != run.result.cameras[d].width_px ||
      of_depth.camera.height_px != run.result.cameras[d].height_px) {
    run.warnings.push_back("the device reports another size of " + names[d] +
                           " than its pictures: " + std::to_string(of_depth.camera.width_px) +
                           " x " + std::to_string(of_depth.camera.height_px));
    return;
  }
  run.registration = registration_difference(
      {of_depth.camera, of_color.camera,
       of_color.sensor_from_rig * inverse(of_depth.sensor_from_rig)},
      run.result, static_cast<int>(d), static_cast<int>(c), run.config.registration);
}

void check_depth_on_boards(CalibrationRun& run) {
  if (run.photos.depths.empty() || run.result.covariance.rows() == 0) return;
  // One depth camera; of several the first.
  const int camera = run.photos.depths.front().camera;
  const auto d = static_cast<std::size_t>(camera);
  const Camera& lens = run.result.cameras[d];
  for (const CalibrationDepth& depth : run.photos.depths) {
    const auto placed = std::find_if(run.result.frames.begin(), run.result.frames.end(),
                                     [&](const auto& f) { return f.frame == depth.frame; });
    if (depth.camera != camera || placed == run.result.frames.end()) continue;
    run.depth_views.push_back(
        {depth.frame, depth_on_target(read_depth(depth), lens,
                                      run.result.camera_from_rig[d] * placed->rig_from_target,
                                      run.photos.target, run.config.depth.step_px)});
  }
  run.depth = check_depth(run.depth_views, run.result, camera, run.config.depth);
}

void warn_of_shutters(CalibrationRun& run) {
  if (run.config.rolling_shutter) return;
  for (const SensorReport& sensor : run.photos.reported) {
    if (sensor.shutter != Shutter::rolling) continue;
    char readout[32];
    std::snprintf(readout, sizeof readout, "%.3g", 1000 * sensor.readout_s);
    run.warnings.push_back(sensor.name + " reads its rows one after the other, over " + readout +
                           " ms: what moves meanwhile is bent; --set rolling_shutter=true takes "
                           "that into account");
  }
}

}  // namespace cousin
