#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "sim/types/camera.h"
#include "sim/types/image.h"
#include "sim/types/mesh.h"
#include "sim/types/pose.h"

namespace cousin {

/// Values that pass between the stages of a pipeline; each is a file of an estimate folder (design
/// §3).
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// ---- corners.json -----------------------------------------------------------------------------
struct CornerObservation {
  int column = 0;  ///< of the board's inner corners
  int row = 0;
  Eigen::Vector2d pixel_px = Eigen::Vector2d::Zero();
  /// Predicted, of (x, y). At grazing views squares are lozenges, and their corners are known well
  /// across the long diagonal and badly along it.
  Eigen::Matrix2d covariance_px2 = 0.01 * Eigen::Matrix2d::Identity();
};
/// Covariance of two independent coordinates of one standard deviation.
inline Eigen::Matrix2d isotropic_px2(double sigma_px) {
  return sigma_px * sigma_px * Eigen::Matrix2d::Identity();
}
/// Standard deviation per axis: the root mean square of both.
inline double rms_sigma_px(const Eigen::Matrix2d& covariance_px2) {
  return std::sqrt(0.5 * covariance_px2.trace());
}
enum class BoardStatus { ok, not_seen, too_few_corners, ambiguous, no_image };
struct FrameCorners {
  int frame = 0;
  BoardStatus status = BoardStatus::not_seen;
  std::vector<CornerObservation> corners;  ///< unique (column, row)
};
using Corners = std::vector<FrameCorners>;  ///< one for each frame of the capture, same order

// ---- poses.json -------------------------------------------------------------------------------
enum class PoseStatus { ok, no_board, degenerate, not_converged };
struct FramePose {
  int frame = 0;
  PoseStatus status = PoseStatus::no_board;
  Pose camera_from_world;  ///< meaningful only when status is ok
  Camera camera;           ///< refined lens of this image
  /// Of (rotation vector of the camera-side increment, translation) in rad and m; zero if unknown.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double rms_px =
      kNaN;  ///< per coordinate: sqrt(sum of squared residual coordinates / their count)
  int corner_count = 0;
};
using Poses = std::vector<FramePose>;  ///< one for each frame, same order

// ---- boxes.json, keypoints.json (COCO results) --------------------------------------------------
/// What a detector finds in one image of one sensor.
struct Detection {
  int frame = 0;
  int sensor = 0;     ///< of the rig: a stereo pair has two images of a frame
  int id = 0;         ///< unique among the seam's entries
  int instance = -1;  ///< the same in all images; -1 = not known
  int category = 1;   ///< in categories.json
  double score = 1;   ///< confidence, 0 to 1
};
struct DetectedBox : Detection {
  Eigen::Vector2d low_px = Eigen::Vector2d::Zero();   ///< edges left and above, from pixel centres
  Eigen::Vector2d high_px = Eigen::Vector2d::Zero();  ///< right and below
  /// Pixels of the object, 255 inside, of a part of the image; empty if only the box is known.
  Image<std::uint8_t> mask;
  Eigen::Vector2i mask_at_px = Eigen::Vector2i::Zero();  ///< its first pixel in the image
  Eigen::Vector2i image_px = Eigen::Vector2i::Zero();    ///< width and height; beside a mask
};
using Boxes = std::vector<DetectedBox>;

enum class KeypointStatus { missing, hidden, seen };  ///< COCO's v: 0, 1, 2
struct DetectedKeypoint {
  KeypointStatus status = KeypointStatus::missing;
  Eigen::Vector2d pixel_px = Eigen::Vector2d::Constant(kNaN);  ///< NaN if missing
  /// Standard deviation per axis; NaN = not given.
  double sigma_px = kNaN;
};
struct KeypointDetection : Detection {
  std::vector<DetectedKeypoint> points;  ///< in the order of its category's names
};
using Keypoints = std::vector<KeypointDetection>;

// ---- depth/*.exr ------------------------------------------------------------------------------
struct FrameDepth {
  int frame = 0;
  Image<float> depth_m;  ///< along the optical axis; NaN = none; empty if the frame was not used
  Image<float> sigma_m;  ///< same size, or empty if unknown
  /// Of the surface: unit, in the camera, towards it; zero = none. Same size, or empty if unknown.
  Image<Eigen::Vector3f> normal;
};
using Depths = std::vector<FrameDepth>;

// ---- cloud.ply, clusters.ply --------------------------------------------------------------------
struct CloudPoint {
  Eigen::Vector3f position_m;                        ///< in the world
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< unit, outward; zero = unknown
  Rgb8 color;
  float sigma_m = 0;  ///< standard deviation along the normal; 0 = unknown
};
using Cloud = std::vector<CloudPoint>;
struct Clusters {
  Cloud cloud;
  std::vector<int> instance;  ///< one for each point; -1 = no seed; instances count from 0
  int count = 0;
};

// ---- masks.json (COCO results) ------------------------------------------------------------------
/// A point of an outline with the direction out of the object.
struct OutlinePoint {
  Eigen::Vector2f pixel_px;
  Eigen::Vector2f normal;  ///< unit, outward in the image
  float sigma_px = 0.1F;   ///< standard deviation along the normal
  bool on_object = true;   ///< false where another object or the image's border cuts the outline
};
struct Silhouette {
  int frame = 0;
  int instance = 0;
  std::vector<OutlinePoint> outline;  ///< closed polygon at sub-pixel precision, in order
};
using Silhouettes = std::vector<Silhouette>;

// ---- fits.json ----------------------------------------------------------------------------------
enum class FitStatus { ok, too_few_points, degenerate, not_converged };
struct FitParameter {
  std::string name;  ///< "centre_x", "radius", ...
  std::string unit;  ///< m, rad, 1
  double value = kNaN;
};
/// A shape of few parameters that stands for an object: a sphere, a line, a plant's axis.
struct ObjectFit {
  int instance = 0;
  std::string model;  ///< "sphere", "line", ...
  FitStatus status = FitStatus::not_converged;
  std::string reason;  ///< why it is not ok
  std::vector<FitParameter> parameters;
  Eigen::MatrixXd covariance;  ///< of the parameters in their order; empty = not given
};
using Fits = std::vector<ObjectFit>;

// ---- meshes/*.ply -------------------------------------------------------------------------------
enum class SurfaceStatus { ok, too_few_views, empty, not_converged, touching, not_watertight };
struct Surface {
  int instance = 0;
  SurfaceStatus status = SurfaceStatus::empty;
  Mesh mesh;  ///< closed, in the world; may be empty for chains that keep points only
  std::vector<Eigen::Vector3d> points_m;  ///< the cluster, for chains that measure points
  /// Equally likely alternatives to `mesh` (same triangles), drawn from the fit's uncertainty.
  std::vector<std::vector<Eigen::Vector3d>> samples_m;
};
using Surfaces = std::vector<Surface>;

// ---- traits.json --------------------------------------------------------------------------------
enum class TraitStatus { ok, not_solved };
struct Trait {
  std::string name;  ///< length, width, height, area, volume
  std::string unit;  ///< m, m2, m3
  double value = kNaN;
  double sigma = kNaN;  ///< standard deviation; NaN = not given
};
struct SpecimenTraits {
  /// Where `frame` is one, the id of the box that was measured: what is measured in one image is
  /// not yet the same in the next.
  int instance = 0;
  int frame = -1;  ///< measured in this frame alone, in its first sensor; -1: over all frames
  TraitStatus status = TraitStatus::not_solved;
  std::string reason;                                                     ///< why not solved
  Eigen::Vector3d centroid_in_world_m = Eigen::Vector3d::Constant(kNaN);  ///< NaN: not known
  std::vector<Trait> traits;
};
using Traits = std::vector<SpecimenTraits>;

/// Names used in files and tables.
std::string_view to_string(BoardStatus status);
std::string_view to_string(PoseStatus status);
std::string_view to_string(FitStatus status);
std::string_view to_string(SurfaceStatus status);
std::string_view to_string(TraitStatus status);

/// Seconds a stage took and what it left in memory.
struct StageTiming {
  std::string stage;
  double wall_s = 0;
  double cpu_s = 0;
  double peak_rss_mb = 0;
  double peak_above_start_mb =
      std::numeric_limits<double>::quiet_NaN();  ///< above the program's start; NaN = not known
};

}  // namespace cousin
