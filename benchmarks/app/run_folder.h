#pragma once

#include <filesystem>
#include <string>

#include "sim/dataset/output_folder.h"

namespace cousin {

/// The folder of a run's results, taken for it. Tables, page and parts of a run of another `key`
/// are removed, so that a run which is stopped leaves none of them beside its own estimates.
/// @param key  of all that decides the results @throws std::invalid_argument naming what is in the
/// way
OutputFolder run_folder(const std::filesystem::path& out, const std::string& key, int scenes);
/// What it would refuse, before any work; makes nothing. @throws as it
void check_run_folder(const std::filesystem::path& out, const std::string& key, int scenes);

}  // namespace cousin
