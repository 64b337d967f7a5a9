#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sim/truth/truth_images.h"
#include "sim/types/calibration_target.h"
#include "sim/types/capture.h"

namespace cousin {

struct BoardPhotographsConfig {
  /// Sensors that see the same light: for each the keys that differ, such as
  /// "rig.color.lens.blur_sigma_px=2".
  std::vector<std::vector<std::string>> sensors = {{}};
  /// Rays of a pixel that an edge crosses; a square number. Their noise falls as its power -3/4: at
  /// 36 it is a tenth of the variance of corners that the sensor's noise leaves.
  int edge_samples = 36;
};

/// Photographs of a board for studies that want thousands of them: the scene, the lens and the
/// sensor are those of `cousin render boards --set ...`, the light is not: each surface's
/// irradiance is traced once a scene and looked up, as for seeds, instead of path by path for each
/// pixel. A board's mirror
/// image of a lamp is there, light that a neighbouring surface throws back too.
class BoardPhotographs {
 public:
  /// @param assignments  keys of `cousin render boards`, such as "board=charuco_a4", "rig=d457",
  /// "views=30", "flaws.warp_x_m=0.001".
  /// @throws std::invalid_argument naming the key; also for a board that moves (place=hand), whose
  /// light cannot be kept, and for a sensor whose lens or places are not the first's.
  BoardPhotographs(const std::vector<std::string>& assignments, std::uint64_t seed,
                   const BoardPhotographsConfig& config = {});
  ~BoardPhotographs();
  BoardPhotographs(BoardPhotographs&&) noexcept;

  const CalibrationTarget& target() const;  ///< as designed
  int size() const;                         ///< number of views
  /// What the rig's cameras hand over in a view: a pure function of (assignments, seed, view, edge
  /// samples), whatever the number of views. May be called from several threads.
  Frame take(int view) const;
  /// The same as each of the sensors hands it over: one rendering. @param sensors  so many of them,
  /// the first ones
  std::vector<Frame> take_each(int view, std::size_t sensors) const;
  /// The true lens and pose of each of the rig's sensors in each view.
  const std::vector<SensorViews>& truth() const;
  /// Where a target's point really is, by id.
  const std::vector<Eigen::Vector3d>& points_in_world_m() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cousin
