#include "sim/types/trait_table.h"

#include <array>
#include <stdexcept>
#include <string>

namespace cousin {

std::span<const TraitRow> trait_table() {
  static constexpr auto kRows = std::to_array<TraitRow>({
      {"length", "m", "mm", 1e3},
      {"width", "m", "mm", 1e3},
      {"height", "m", "mm", 1e3},
      {"area", "m2", "mm²", 1e6},
      {"volume", "m3", "mm³", 1e9},
      {"mass", "kg", "g", 1e3},
      {"diameter", "m", "mm", 1e3},
      {"leaf_area", "m2", "mm²", 1e6},
      {"visible_leaf_area", "m2", "mm²", 1e6},
      {"leaves", "1", "", 1, TraitScoring::count},
      {"fruit_count", "1", "", 1},
      {"yield", "kg", "kg", 1},
      {"maturity", "1", "", 1, TraitScoring::count},
      {"point_x", "m", "mm", 1e3, TraitScoring::absolute},
      {"point_y", "m", "mm", 1e3, TraitScoring::absolute},
      {"point_z", "m", "mm", 1e3, TraitScoring::absolute},
      {"distance", "m", "mm", 1e3, TraitScoring::absolute},
      {"centre_x", "m", "mm", 1e3, TraitScoring::absolute},
      {"centre_y", "m", "mm", 1e3, TraitScoring::absolute},
      {"centre_z", "m", "mm", 1e3, TraitScoring::absolute},
      {"calyx_x", "m", "mm", 1e3, TraitScoring::absolute},
      {"calyx_y", "m", "mm", 1e3, TraitScoring::absolute},
      {"calyx_z", "m", "mm", 1e3, TraitScoring::absolute},
      {"cut_x", "m", "mm", 1e3, TraitScoring::absolute},
      {"cut_y", "m", "mm", 1e3, TraitScoring::absolute},
      {"cut_z", "m", "mm", 1e3, TraitScoring::absolute},
      {"axis_x", "1", "", 1, TraitScoring::absolute},
      {"axis_y", "1", "", 1, TraitScoring::absolute},
      {"axis_z", "1", "", 1, TraitScoring::absolute},
      {"approach_x", "1", "", 1, TraitScoring::absolute},
      {"approach_y", "1", "", 1, TraitScoring::absolute},
      {"approach_z", "1", "", 1, TraitScoring::absolute},
      {"red_share", "1", "%", 100, TraitScoring::absolute},
      {"internode", "m", "mm", 1e3},
      {"internode_geodesic", "m", "mm", 1e3},
      {"plant_height", "m", "mm", 1e3},
  });
  return kRows;
}

const TraitRow* find_trait(std::string_view name) {
  for (const TraitRow& row : trait_table()) {
    if (row.name == name) return &row;
  }
  return nullptr;
}

const TraitRow& trait_row(std::string_view name) {
  if (const TraitRow* row = find_trait(name)) return *row;
  std::string known;
  for (const TraitRow& row : trait_table())
    known += (known.empty() ? "" : ", ") + std::string(row.name);
  throw std::invalid_argument("trait \"" + std::string(name) + "\" is not one of " + known);
}

}  // namespace cousin
