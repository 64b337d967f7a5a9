#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "sim/types/camera.h"
#include "sim/types/image.h"
#include "sim/types/pose.h"

namespace cousin {

/// The true lens and motion of one exposure.
struct TrueView {
  int frame = 0;
  double time_s = 0;
  Camera camera;               ///< the lens as it was, this image
  Pose camera_from_world;      ///< when the first row is read
  Pose camera_from_world_end;  ///< when the last row is read; equal for a global shutter
  /// Each row's, centred on its time; 0 = an instant. With a global shutter (readout_s 0) the
  /// camera goes from begin to end during it.
  double exposure_s = 0;
  double readout_s = 0;          ///< from the first row's time to the last's; time_s is the first's
  double aperture_radius_m = 0;  ///< of a thin lens; 0 = pinhole
  double focus_m = std::numeric_limits<double>::infinity();  ///< depth that is sharp
};

/// Pose when row `y` is read: linear in the row; with a global shutter and an exposure, its middle.
Pose pose_at_row(const TrueView& view, double y);
/// The time when row `y` is read.
double time_at_row(const TrueView& view, double y);

/// Pose and time at a share of the exposure of row `y`, 0 = its begin, 1 = its end.
Pose pose_in_exposure(const TrueView& view, double y, double share);
double time_in_exposure_s(const TrueView& view, double y, double share);

/// How much of one instance a view shows.
struct InstanceVisibility {
  int instance = 0;
  std::int64_t pixels_full = 0;     ///< rays of the image that would hit it were it alone (amodal)
  std::int64_t pixels_visible = 0;  ///< rays that hit it first
  double visible_fraction = 0;      ///< pixels_visible / pixels_full; 0 if it is not in the image
  int box_x = 0, box_y = 0, box_width = 0, box_height = 0;  ///< of the full mask, pixels
  int seen_x = 0, seen_y = 0, seen_width = 0,
      seen_height = 0;  ///< of the visible mask, pixels; zeros if nothing is seen
};

/// What part of one pixel's area shows an instance.
struct PixelShare {
  std::int32_t x = 0, y = 0;
  float share = 0;  ///< in (0, 1]
  bool operator==(const PixelShare&) const = default;
};

/// An instance's pixels by area rather than by centres, so that what falls between centres counts:
/// a stem thinner than a pixel has no pixel in the visible mask and its true area here.
struct InstanceShares {
  int instance = 0;
  int width_px = 0, height_px = 0;  ///< of the image
  std::vector<PixelShare> pixels;   ///< row by row
  double area_px = 0;               ///< the sum of the shares
};

enum class PointState : std::uint8_t {
  none,      ///< no surface there
  visible,   ///< seen
  occluded,  ///< inside the image, behind something
  outside,   ///< outside the image, or where the lens makes none
};

/// A keypoint of an instance as one view shows it.
struct KeypointView {
  int instance = 0;
  int keypoint = 0;  ///< into the model's keypoints
  PointState state = PointState::none;
  Eigen::Vector2d pixel_px =
      Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());  ///< NaN = no image
  double depth_m = std::numeric_limits<double>::quiet_NaN();  ///< along the optical axis
};

/// Leaf surface of an instance, one side, and what a view shows of it. Points that share the area
/// evenly stand for it, the same in every view, so that views can be taken together.
struct LeafAreaView {
  int instance = 0;
  double whole_m2 = 0;
  std::vector<bool> is_seen;  ///< one for each point
};
/// Area seen in any of several views of one instance.
double seen_area_m2(const std::vector<const LeafAreaView*>& views);

/// Where another view sees what each pixel's centre shows.
struct ViewMatch {
  Image<Eigen::Vector2f> flow_px;  ///< pixel there less pixel here; NaN = no surface, or no image
  Image<PointState> state;         ///< there
};

/// One sample through each pixel's centre. Images that were not asked for stay empty.
struct TruthImages {
  Image<float> depth_m;               ///< along the optical axis; NaN = no surface
  Image<Eigen::Vector3f> normal;      ///< geometric, unit, in the camera, towards it; zero = none
  Image<Eigen::Vector3f> position_m;  ///< in the world; NaN = none
  Image<std::int32_t> instance;       ///< Instance::id; -1 = none
  Image<std::uint16_t> part;          ///< part of the instance; 65535 = none
  Image<float>
      specimen_coverage;  ///< share of the pixel's area that shows a specimen, from several samples
  std::vector<InstanceVisibility> visibility;  ///< specimens, by id
  std::vector<Image<std::uint8_t>>
      masks_full;                      ///< one for each of `visibility`: 255 inside the amodal mask
  std::vector<InstanceShares> shares;  ///< specimens, by id
  std::vector<KeypointView> keypoints;   ///< of the specimens by id, in the models' order
  std::vector<LeafAreaView> leaf_areas;  ///< of the specimens by id
  ViewMatch flow;                        ///< in the next view of the scene
  ViewMatch stereo;  ///< in the rig's second camera, at the same time; disparity = -flow_px.x()
  // Of the rig's depth sensor, in its own pixels.
  Image<float> noise_free_depth_m;     ///< along its optical axis; NaN = no surface
  Image<std::uint8_t> invalid_reason;  ///< why there is no depth; 0 = there is
};

/// The true lenses and poses of one sensor of a rig, one for each frame, and what it sees.
struct SensorViews {
  std::string sensor;
  std::vector<TrueView> views;
  std::vector<TruthImages> images = {};  ///< one for each view, or empty
};

}  // namespace cousin
