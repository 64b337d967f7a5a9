#include "benchmarks/loop/specimens_text.h"

#include <algorithm>
#include <cstdint>
#include <set>
#include <tuple>

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

std::string name_of(const SpecimenTraits& traits) {
  const std::string number = std::to_string(traits.instance);
  return traits.frame < 0 ? "specimen " + number
                          : "box " + number + " of view " + std::to_string(traits.frame);
}

std::vector<std::string> unmeasured_lines(const Traits& traits) {
  std::vector<std::string> lines;
  for (const SpecimenTraits& specimen : traits) {
    if (specimen.status == TraitStatus::ok) continue;
    lines.push_back("  " + name_of(specimen) + " is not measured" +
                    (specimen.reason.empty() ? "" : ": " + specimen.reason));
  }
  return lines;
}

std::string unmeasured_sentence(const std::vector<SpecimenRow>& specimens) {
  std::set<std::tuple<std::string, std::int64_t, std::int64_t>> all, measured;
  bool is_of_boxes = false, is_of_plants = false;
  for (const SpecimenRow& row : specimens) {
    is_of_boxes = is_of_boxes || row.frame >= 0;
    is_of_plants = is_of_plants || row.trait == "internode";
    all.emplace(row.scene, row.frame, row.instance);
    if (row.status == ScoreStatus::ok) measured.emplace(row.scene, row.frame, row.instance);
  }
  if (measured.size() == all.size()) return {};
  return std::to_string(measured.size()) + " of " + std::to_string(all.size()) +
         (is_of_plants  ? " internodes and plants"
          : is_of_boxes ? " boxes"
                        : " specimens") +
         " are measured; errors are of these alone.";
}

}  // namespace cousin
