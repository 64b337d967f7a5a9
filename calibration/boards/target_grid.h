#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "sim/types/calibration_target.h"

namespace cousin {

/// A target's points with their neighbours.
class TargetGrid {
 public:
  explicit TargetGrid(const CalibrationTarget& target);
  const CalibrationTarget& target() const { return target_; }
  const std::vector<TargetPoint>& points() const { return points_; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  /// Index into points(), or -1 where the lattice has none.
  int at(int column, int row) const;

 private:
  CalibrationTarget target_;
  std::vector<TargetPoint> points_;
  std::vector<int> index_;
  int columns_ = 0, rows_ = 0;
};

/// Where an image is thought to show each of a grid's points, by index.
using FoundPixels = std::vector<std::optional<Eigen::Vector2d>>;
int count_found(const FoundPixels& found);

/// The print about one point: affine.
struct LocalMap {
  Eigen::Vector2d pixel_px;  ///< of the point
  Eigen::Matrix2d px_per_m;  ///< columns: along the target's x and y
};
/// Length of the shorter of a step of the grid along x and y, in pixels.
double step_px(const LocalMap& map, const CalibrationTarget& target);

/// Fitted to the found points within two places of `index`, that point itself left out; nothing if
/// they lie on a line or are fewer than three.
std::optional<LocalMap> local_map(const TargetGrid& grid, const FoundPixels& found, int index);

/// Takes away points that lie farther than `max_share` of a step from where their neighbours have
/// them, worst first. Returns how many.
int drop_strays(const TargetGrid& grid, FoundPixels& found, double max_share);

/// Takes away measured points that lie farther than `max_share` of a step from where a homography
/// of the found points within three places has them, worst first. Stricter than `drop_strays`: a
/// homography follows perspective past the outermost points, where a corner that lies outside the
/// picture may be taken for one of a marker's. Points with fewer than eight others about them stay.
/// Returns how many.
int drop_misplaced(const TargetGrid& grid, FoundPixels& found, double max_share);

/// Whether the points are seen from the printed side: most local maps turn y up into y down.
bool is_face_seen(const TargetGrid& grid, const FoundPixels& found);

}  // namespace cousin
