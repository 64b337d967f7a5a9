#pragma once

#include <filesystem>
#include <vector>

#include "benchmarks/app/options.h"
#include "sim/dataset/output_folder.h"

namespace cousin {

/// What `cousin perceive` reads and where it writes.
struct PerceivePlaces {
  std::filesystem::path dataset, out;
  std::vector<std::filesystem::path> scenes;
};
/// @throws std::invalid_argument if estimates would lie in the dataset; std::runtime_error if that
/// holds no scene
PerceivePlaces perceive_places(const Options& options);

/// The folder of the estimates, taken for this command. @param has_page  a table and a page are
/// written too. @throws std::invalid_argument naming what
/// is in the way
OutputFolder estimate_folder(const PerceivePlaces& places, bool has_page);

/// 3 of a folder "000003"; 0 of any other.
int scene_index_of(const std::filesystem::path& scene);

}  // namespace cousin
