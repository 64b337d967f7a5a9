#pragma once

#include <filesystem>

#include "benchmarks/suites/real/real_rows.h"
#include "perception/mvs/plane_sweep.h"

namespace cousin {

/// Where the cameras look: a cube about the point nearest to all optical axes, its half side a
/// share of the median distance to it. Frames without a pose do not count.
/// @throws std::invalid_argument if fewer than two axes, or parallel ones, are given.
SweepVolume volume_looked_at(const Poses& poses, double half_side_over_distance);

/// Poses that the capture itself carries, with each frame's reported lens.
Poses poses_of(const Capture& capture);

/// The same capture with images and lenses scaled by `factor` (0..1], averaging the pixels covered.
Capture scaled_capture(Capture capture, double factor);

/// The fox of instant-ngp: 50 telephone photographs, lens and poses by COLMAP, through the reader,
/// the lens model and multi-view stereo. There is no true shape: rows say how much depth there is
/// and how well the depths of different views agree. Lengths are the file's own unit, not metres.
/// Writes out/fox.ply and, for each view with depth, out/fox_<frame>_photo.png, _undistorted.png
/// (through the lens model to a pinhole) and _depth.png (near is red, far is blue). Cloud and
/// pictures hold the depths that another view confirms within 1 %; the rows count all.
RealPart fox_stereo(const std::filesystem::path& real_data, const std::filesystem::path& out,
                    bool quick);

}  // namespace cousin
