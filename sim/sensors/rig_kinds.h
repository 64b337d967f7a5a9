#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "sim/sensors/device.h"
#include "sim/sensors/metering.h"
#include "sim/sensors/range_rig.h"
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
struct RangeRig {
  RangeRigConfig config;
  RangeRigUnit unit;
  CameraRig color;  ///< the colour camera alone
};
using RigKind = std::variant<PhoneRig, CameraRig, DepthRig, RangeRig>;
/// @throws std::invalid_argument if a configuration is invalid, or depth cannot come from where
/// `depth_by` says.
RigKind make_rig_kind(const DeviceConfig& device, DepthBy depth_by, const Rng& rng);

/// Cameras that take colour: the first of the sensors.
std::size_t camera_count(const PhoneRig& rig);
std::size_t camera_count(const CameraRig& rig);
std::size_t camera_count(const DepthRig& rig);
std::size_t camera_count(const RangeRig& rig);

/// Places of a stereo depth camera's sensors.
inline constexpr std::size_t kLeftSensor = 1, kRightSensor = 2;
/// Place of the sensor that has depth, if there is one.
std::optional<std::size_t> depth_place(const PhoneRig& rig);
std::optional<std::size_t> depth_place(const CameraRig& rig);
std::optional<std::size_t> depth_place(const DepthRig& rig);
std::optional<std::size_t> depth_place(const RangeRig& rig);

std::vector<SensorReport> reports_of(const PhoneRig& rig);
std::vector<SensorReport> reports_of(const CameraRig& rig);
std::vector<SensorReport> reports_of(const DepthRig& rig);
std::vector<SensorReport> reports_of(const RangeRig& rig);

/// True views of all sensors in one frame. @param rng  of the frame's views.
std::vector<TrueView> views_of(const PhoneRig& rig, const Scene& scene, int frame, const Rng& rng);
std::vector<TrueView> views_of(const CameraRig& rig, const Scene& scene, int frame, const Rng& rng);
std::vector<TrueView> views_of(const DepthRig& rig, const Scene& scene, int frame, const Rng& rng);
std::vector<TrueView> views_of(const RangeRig& rig, const Scene& scene, int frame, const Rng& rng);

/// One sensor's frame without images. @param rng  of the frame's sensing.
SensorFrame reported_frame(const PhoneRig& rig, std::size_t sensor, const TrueView& view,
                           const View& seen, const Rng& rng);
SensorFrame reported_frame(const CameraRig& rig, std::size_t sensor, const TrueView& view,
                           const View& seen, const Rng& rng);
SensorFrame reported_frame(const DepthRig& rig, std::size_t sensor, const TrueView& view,
                           const View& seen, const Rng& rng);
SensorFrame reported_frame(const RangeRig& rig, std::size_t sensor, const TrueView& view,
                           const View& seen, const Rng& rng);

/// A camera's images. @param spot  that automatic exposure is for @param rng  of the frame's
/// sensing.
SensorFrame sense_color(const PhoneRig& rig, std::size_t sensor, const Image<Rgbf>& radiance,
                        const TrueView& view, const MeteredSpot& spot, const Rng& rng);
SensorFrame sense_color(const CameraRig& rig, std::size_t sensor, const Image<Rgbf>& radiance,
                        const TrueView& view, const MeteredSpot& spot, const Rng& rng);
SensorFrame sense_color(const DepthRig& rig, std::size_t sensor, const Image<Rgbf>& radiance,
                        const TrueView& view, const MeteredSpot& spot, const Rng& rng);
SensorFrame sense_color(const RangeRig& rig, std::size_t sensor, const Image<Rgbf>& radiance,
                        const TrueView& view, const MeteredSpot& spot, const Rng& rng);

/// What a rig's depth is made from in one frame.
struct DepthTake {
  const RayScene& rays;
  const Scene& scene;
  Pose rig_from_world;
  DepthBy depth_by = DepthBy::matched;
  Rng rig;    ///< the rig's: what is fixed from frame to frame
  Rng frame;  ///< of the frame's sensing
};
/// Infrared images and depth, those that `streams` asks for, and what is true of them. A rig
/// without a depth sensor gives none.
void take_depth(const PhoneRig& rig, const DepthTake& from, const Streams& streams, RigFrame& into);
void take_depth(const CameraRig& rig, const DepthTake& from, const Streams& streams,
                RigFrame& into);
void take_depth(const DepthRig& rig, const DepthTake& from, const Streams& streams, RigFrame& into);
void take_depth(const RangeRig& rig, const DepthTake& from, const Streams& streams, RigFrame& into);

}  // namespace cousin
