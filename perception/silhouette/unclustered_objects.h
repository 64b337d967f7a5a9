#pragma once

#include <Eigen/Core>
#include <vector>

#include "perception/segment/green.h"
#include "sim/types/board.h"
#include "sim/types/capture.h"
#include "sim/types/seams.h"

namespace cousin {

/// An object that photographs show on the board and that no cluster is of.
struct UnclusteredObject {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();  ///< of its foot, on the board
  double area_m2 = 0;                                  ///< of its foot
  int views = 0;                                       ///< that show it
  int points = 0;                                      ///< of the cloud that stand on its foot
};

/// What a pipeline would lose without a word: coloured things on the grey board by their colour
/// alone, without depth. Each cell of the plate is looked up in up to 24 posed views, whose colours
/// are balanced by the paper; where three quarters of them are coloured, and not as the green
/// screen, something stands. Objects that touch are one, and grey ones are not seen: the count is a
/// least one.
std::vector<UnclusteredObject> unclustered_objects(const Capture& capture, const Poses& poses,
                                                   const SeedBoard& board, const Clusters& clusters,
                                                   const GreenConfig& green);

}  // namespace cousin
