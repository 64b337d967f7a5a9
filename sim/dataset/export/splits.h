#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "sim/dataset/export/export_scene.h"

namespace cousin {

enum class Split { train, val, test };
inline constexpr std::array<Split, 3> kSplits = {Split::train, Split::val, Split::test};
std::string_view to_string(Split split);

/// The side of each scene. Scenes that show a plant that another one shows too
/// (SceneTruth::shared_plants: a growth series, a plant in another light) are on the same side, so
/// that no plant and no view of it is in two. Groups are taken in an order that depends on their
/// scenes' numbers alone (by SHA-256), first into test, then into val, until each has its share of
/// the pictures to within a group; the rest is train, which is never empty.
/// @param needed  val or test: what gets the second group where there are only two.
std::vector<Split> splits_of(const std::vector<ExportScene>& scenes,
                             const std::array<double, 3>& shares, Split needed = Split::test);

/// What to say where a side that should have pictures has none: "val and test are empty: ...";
/// empty = nothing.
std::string empty_splits(const std::vector<Split>& splits, const std::array<double, 3>& shares);

}  // namespace cousin
