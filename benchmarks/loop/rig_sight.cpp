#include "benchmarks/loop/rig_sight.h"

#include <algorithm>

namespace cousin {
namespace {

RigSight sight(const PhoneConfig& rig) {
  RigSight seen{.readout_s = rig.readout_s};
  Camera& camera = seen.eye.camera;
  camera.width_px = rig.width_px;
  camera.height_px = rig.height_px;
  camera.fx_px = camera.fy_px = rig.focal_px_per_width * rig.width_px;
  camera.cx_px = 0.5 * (rig.width_px - 1);
  camera.cy_px = 0.5 * (rig.height_px - 1);
  return seen;
}

RigSight sight(const RigConfig& rig) {
  const RigSensor& first = rig.sensors.at(0);
  RigSight seen{.eye = {nominal_camera(first.camera), sensor_from_rig(first)}};
  for (const RigSensor& sensor : rig.sensors)
    seen.readout_s = std::max(seen.readout_s, sensor.camera.photosites.readout_s);
  return seen;
}

RigSight sight(const ActiveStereoConfig& rig) {
  RigSight seen{.eye = {color_camera(rig), {}}, .readout_s = rig.color.photosites.readout_s};
  seen.eye.eye_from_rig.translation_m.x() = -rig.color_x_m;
  return seen;
}

RigSight sight(const RangeRigConfig& rig) { return sight(rig.body); }

}  // namespace

RigSight sight_of(const DeviceConfig& rig) {
  return std::visit([](const auto& own) { return sight(own); }, rig);
}

}  // namespace cousin
