#pragma once

#include <variant>
#include <vector>

#include "sim/sensors/device.h"
#include "sim/sensors/rig_capture.h"

namespace cousin {

/// Particular rigs of each kind, and what RigCapture asks of them. Private to sim/sensors.
struct PhoneRig {
  PhoneConfig config;
  PhoneUnit unit;
};
struct CameraRig {
  RigConfig config;
  RigUnit unit;
};
struct DepthRig {
  ActiveStereoConfig config;
  ActiveStereoUnit unit;
  CameraRig color;  ///< the colour camera alone; its place in the rig as reported
};
using RigKind = std::variant<PhoneRig, CameraRig, DepthRig>;
RigKind make_rig_kind(const DeviceConfig& device, const Rng& rng);

/// Cameras that take colour: the first of the sensors.
std::size_t camera_count(const PhoneRig& rig);
std::size_t camera_count(const CameraRig& rig);
std::size_t camera_count(const DepthRig& rig);

std::vector<SensorReport> reports_of(const PhoneRig& rig);
std::vector<SensorReport> reports_of(const CameraRig& rig);
std::vector<SensorReport> reports_of(const DepthRig& rig);

/// True views of all sensors in one frame. @param rng  of the frame's views.
std::vector<TrueView> views_of(const PhoneRig& rig, const Scene& scene, int frame, const Rng& rng);
std::vector<TrueView> views_of(const CameraRig& rig, const Scene& scene, int frame, const Rng& rng);
std::vector<TrueView> views_of(const DepthRig& rig, const Scene& scene, int frame, const Rng& rng);

/// One sensor's frame without images. @param rng  of the frame's sensing.
SensorFrame reported_frame(const PhoneRig& rig, std::size_t sensor, const TrueView& view,
                           const View& seen, const Rng& rng);
SensorFrame reported_frame(const CameraRig& rig, std::size_t sensor, const TrueView& view,
                           const View& seen, const Rng& rng);
SensorFrame reported_frame(const DepthRig& rig, std::size_t sensor, const TrueView& view,
                           const View& seen, const Rng& rng);

/// A camera's images. @param rng  of the frame's sensing.
SensorFrame sense_color(const PhoneRig& rig, std::size_t sensor, const Image<Rgbf>& radiance,
                        const TrueView& view, const Rng& rng);
SensorFrame sense_color(const CameraRig& rig, std::size_t sensor, const Image<Rgbf>& radiance,
                        const TrueView& view, const Rng& rng);
SensorFrame sense_color(const DepthRig& rig, std::size_t sensor, const Image<Rgbf>& radiance,
                        const TrueView& view, const Rng& rng);

/// Places of a depth camera's sensors.
inline constexpr std::size_t kLeftSensor = 1, kRightSensor = 2, kDepthPlace = 3;

struct DepthRigTake {
  const RayScene& rays;
  const Scene& scene;
  Pose rig_from_world;
  Rng rig;    ///< the rig's: what is fixed from frame to frame
  Rng frame;  ///< of the frame's sensing
};
/// Renders the infrared pair; gives the images and, if asked and `depth` says so, matches them.
void take_matched(const DepthRig& rig, const DepthRigTake& from, const Streams& streams, bool depth,
                  RigFrame& into);
void take_modelled(const DepthRig& rig, const DepthRigTake& from, RigFrame& into);

}  // namespace cousin
