#pragma once

#include <optional>
#include <vector>

#include "calibration/bundle/bundle_adjustment.h"
#include "perception/sfm/sfm_model.h"
#include "sim/types/board.h"
#include "sim/types/seams.h"

namespace cousin {

/// `shared`: one lens for all images; `per_image`: a factor an image on its focal lengths, adjusted
/// with all else.
enum class SfmFocal { shared, per_image };

/// A model as a bundle adjustment starts from it; image i is the model's i-th, point p its p-th.
/// @param lens  all images' start; none: the model's own, which of images is the first
/// @param sigma_px  of each sighting
BundleAdjustmentInput track_bundle(const SfmModel& model, const std::optional<Camera>& lens,
                                   double sigma_px);

/// Corners of a board among the images of a bundle.
struct BoardCorner {
  int column = 0, row = 0;
  Eigen::Vector3d in_world_m;                   ///< triangulated, in the bundle's unit
  std::vector<BundleObservation> observations;  ///< `point` is not set
};
/// Corners that at least two images show whose status is ok, triangulated by the bundle's poses;
/// those that no place explains are left out.
/// @param images  of the bundle: which of `corners`' entries each is
/// @param floor_px  added in quadrature to each predicted deviation
std::vector<BoardCorner> board_corners(const BundleAdjustmentResult& bundle,
                                       const std::vector<Camera>& lens_of_image,
                                       const std::vector<int>& images, const Corners& corners,
                                       double floor_px);

/// True over model length of the sides of the board's squares.
struct SquareScale {
  int sides = 0;
  double scale = kNaN;        ///< mean side of the print over the mean side of the model
  double sigma_share = kNaN;  ///< of the mean, from the sides' scatter; 0.. over the scale
};
SquareScale scale_by_squares(const SeedBoard& board, const std::vector<BoardCorner>& corners);

}  // namespace cousin
