#pragma once

#include <filesystem>

#include "benchmarks/suites/real/real_rows.h"

namespace cousin {

/// Real maize plants on a turntable, carved from their 13 silhouettes and compared with the
/// carvings that OpenAlea phenomenal published: agreement of two programs, not accuracy; nobody
/// measured the plants. Ours runs on the published grid. It is run with every view needed ("hull,
/// no miss") and with one view allowed to miss a voxel ("hull, one miss"), since many of the
/// published voxels lie outside one silhouette. Clouds of voxel centres:
/// out/plant_2_8mm_no_miss.ply and so on; silhouettes with the voxels on them:
/// out/plant_2_no_miss.png and out/plant_2_one_miss.png.
RealPart maize_carving(const std::filesystem::path& real_data, const std::filesystem::path& out,
                       bool quick);

}  // namespace cousin
