#include "benchmarks/app/specimens_text.h"

#include <algorithm>
#include <set>
#include <utility>

namespace cousin {

std::string specimens_text(const Traits& traits) {
  const auto measured = std::count_if(
      traits.begin(), traits.end(),
      [](const SpecimenTraits& specimen) { return specimen.status == TraitStatus::ok; });
  if (measured == static_cast<std::ptrdiff_t>(traits.size()))
    return std::to_string(traits.size()) + " specimens";
  return std::to_string(measured) + " of at least " + std::to_string(traits.size()) +
         " objects measured";
}

std::vector<std::string> unmeasured_lines(const Traits& traits) {
  std::vector<std::string> lines;
  for (const SpecimenTraits& specimen : traits) {
    if (specimen.status == TraitStatus::ok) continue;
    lines.push_back("  seed " + std::to_string(specimen.instance) + " is not measured" +
                    (specimen.reason.empty() ? "" : ": " + specimen.reason));
  }
  return lines;
}

std::string unmeasured_sentence(const std::vector<SpecimenRow>& specimens) {
  std::set<std::pair<std::string, int>> all, measured;
  for (const SpecimenRow& row : specimens) {
    all.emplace(row.scene, row.instance);
    if (row.status == ScoreStatus::ok) measured.emplace(row.scene, row.instance);
  }
  if (measured.size() == all.size()) return {};
  return std::to_string(measured.size()) + " of " + std::to_string(all.size()) +
         " specimens are measured; errors are of these alone.";
}

}  // namespace cousin
