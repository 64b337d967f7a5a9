#pragma once

#include <span>
#include <string_view>

namespace cousin {

/// How a measured trait is held against the true one.
enum class TraitScoring {
  relative,  ///< by its error over the true value too
  absolute,  ///< by its error alone: the true value may be 0
  count,     ///< by how often it is the very number
  angle      ///< by its error modulo a turn
};

/// A trait's unit and how it is scored and shown.
struct TraitRow {
  std::string_view name;
  std::string_view unit;   ///< SI, as files have it
  std::string_view shown;  ///< the unit that people see; empty for a number without one
  double factor = 1;       ///< from the SI unit to that
  TraitScoring scoring = TraitScoring::relative;
};

/// To add a trait, add a row.
std::span<const TraitRow> trait_table();
/// Null for a name that no row has: somebody's own trait is shown in its SI unit.
const TraitRow* find_trait(std::string_view name);
/// @throws std::invalid_argument listing the names that exist
const TraitRow& trait_row(std::string_view name);

}  // namespace cousin
