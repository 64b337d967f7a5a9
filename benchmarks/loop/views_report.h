#pragma once

#include <filesystem>

#include "benchmarks/loop/report_scene.h"
#include "sim/dataset/truth_io.h"

namespace cousin {

/// What a page shows of an estimate that the pipeline views wrote: its pictures, Gaussians, cloud
/// and mesh, and the true surfaces: the specimens', or all where there are none. Its name is the
/// folder's.
/// @throws std::runtime_error naming a file that is not as it was written
ReportScene views_report_scene(const std::filesystem::path& estimate_dir, const SceneTruth& truth);

}  // namespace cousin
