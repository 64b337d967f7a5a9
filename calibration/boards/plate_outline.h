#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/boards/grid_growth.h"
#include "sim/types/board.h"
#include "sim/types/camera.h"
#include "sim/types/image.h"

namespace cousin {

/// The corner lattice sought in the plate turned upright: for views so low that squares are two
/// pixels high. The plate is the largest thing in the image that is not green; four straight sides
/// are fitted to its outline and the image is warped so that squares come out square, in which
/// `find_saddles` and `grow_lattice` work as in a view from above.
/// @param perceptual  the image in which saddles are sought, same size as `color`
/// @return corners in pixels of the image; empty where no four-sided plate stands on green
std::vector<LatticeCorner> lattice_of_upright_plate(const Image<Rgb8>& color,
                                                    const Image<float>& perceptual,
                                                    const SeedBoard& board, double smoothing_px,
                                                    double contrast);

/// Where the board would be if the outline on the green screen is the plate's: homographies from
/// the board (m) to x/z, y/z of the camera. For each turn of the print (one for a plain board)
/// there is one for each of several thicknesses of the plate, whose side belongs to the outline
/// too; one of them is right to about a pixel. Empty where no four-sided plate stands whole on
/// green.
std::vector<std::vector<Eigen::Matrix3d>> boards_in_outline(const Image<Rgb8>& color,
                                                            const Camera& camera,
                                                            const SeedBoard& board);

}  // namespace cousin
