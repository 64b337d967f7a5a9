#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// Whether a trait is a coordinate of a fruit's place or direction in the camera: centre_x,
/// calyx_y, cut_z, axis_x, approach_y, ...
bool is_of_place(std::string_view trait);

/// Errors of places over the boxes of one case, from their specimen rows: for centre, calyx and cut
/// the median distance from the true one, `.error_3d`, and that across the true line of sight,
/// `.error_lateral`, their root mean squares, `.rmse_3d`, `.rmse_lateral`; of cuts the share within
/// 2, 5 and 10 mm of all boxes there are, `cut.within_2_mm`; for axis and
/// approach the median angle, `axis.error_angle`, and the share within 10 degrees of all boxes.
/// @param rows  of whole boxes, box after box, each with the same traits in the same order
/// @param traits  of each box
void add_place_rows(std::span<const SpecimenRow> rows, std::span<const std::string_view> traits,
                    const ScoreRow& base, std::vector<ScoreRow>& scores);

}  // namespace cousin
