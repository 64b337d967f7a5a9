#pragma once

#include <filesystem>
#include <string>

#include "benchmarks/tools/fit_sensor/fit_rows.h"

namespace cousin {

/// The page of a fit: verdict, plots of sigma_Z, noise, fill, ripple and photon transfer over what
/// they depend on, all rows, the preset; one self-contained HTML file, written whole or not at all.
/// @param scores  fit_rows, with its header filled
void write_fit_report(const std::filesystem::path& file, const SensorFit& fit,
                      const ScoreFile& scores, const std::string& command_line);

}  // namespace cousin
