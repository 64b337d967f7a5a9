#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace cousin {

/// A folder of results that is kept, as an index shows it.
struct KeptResults {
  std::string name;     ///< of the folder
  std::string made_by;  ///< the first paragraph of its about.md, cut; empty without one
  std::int64_t rows = 0;
  std::int64_t kept = 0, broken = 0;  ///< of the rows that have a limit
  std::int64_t unsolved = 0;          ///< rows that say not_solved, not_built or error
};

/// The folders below `folder` that hold scores.csv, by name.
/// @throws std::runtime_error naming the file and what is wrong
std::vector<KeptResults> kept_results(const std::filesystem::path& folder);

/// README.md of such a folder: a sentence of all, a line each, the plot.
std::string results_index(const std::vector<KeptResults>& results);

/// A bar a folder, as SVG: how many limits are kept and how many are not.
std::string results_plot(const std::vector<KeptResults>& results);

}  // namespace cousin
