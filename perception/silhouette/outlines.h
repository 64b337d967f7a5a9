#pragma once

#include "sim/config/fields.h"
#include "sim/types/board.h"
#include "sim/types/capture.h"
#include "sim/types/seams.h"

namespace cousin {

struct OutlineConfig {
  double margin_px = 6;        ///< searched beyond the cluster's projection
  double min_contrast = 0.05;  ///< in linear colour, between seed and board across the outline
  double blur_sigma_px =
      0.5;  ///< Gaussian of lens and pixel response, on top of the pixel's square
};
Fields fields(OutlineConfig& config);
void validate(const OutlineConfig& config);

/// Sub-pixel outlines of every clustered object in every posed view, from the first sensor's
/// images. What the board should look like behind each pixel is known from the pose and the print,
/// so each pixel is split into object and board:
/// 1. paper and ink are measured on the plate around the object; the object's colour inside its
/// cluster's projection;
/// 2. each pixel near the cluster is a sum of both; the largest piece with more object than board
/// is the first outline;
/// 3. along it, an edge blurred by the lens is fitted to the pixels on both sides, with the
/// object's shading and the board's
///    print, shadow and reflected colour as unknowns (edge_fit.h), twice.
/// Where another object or the image's border is near, or the fit is not sure, points say on_object
/// = false. Sorted by frame, then instance; views without a pose, or where the object is not seen,
/// have none.
Silhouettes find_outlines(const Capture& capture, const Poses& poses, const SeedBoard& board,
                          const Clusters& clusters, const OutlineConfig& config = {});

}  // namespace cousin
