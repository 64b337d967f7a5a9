#include "sim/dataset/export/splits.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "sim/dataset/manifest.h"

namespace cousin {
namespace {

/// For each scene the first one that it shares plants with, directly or through others.
std::vector<std::size_t> groups_of(const std::vector<ExportScene>& scenes) {
  std::vector<std::size_t> parent(scenes.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i];
    return i;
  };
  std::map<std::string, std::size_t> first_with;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (!scenes[i].truth) continue;
    for (const std::string& plant : scenes[i].truth->shared_plants) {
      const std::size_t a = root(first_with.emplace(plant, i).first->second), b = root(i);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = root(i);
  return parent;
}

}  // namespace

std::string_view to_string(Split split) {
  return split == Split::train ? "train" : split == Split::val ? "val" : "test";
}

std::vector<Split> splits_of(const std::vector<ExportScene>& scenes,
                             const std::array<double, 3>& shares, Split needed) {
  const std::vector<std::size_t> group = groups_of(scenes);
  std::map<std::string, std::size_t> order;  // hash, first scene
  std::map<std::size_t, std::size_t> pictures;
  std::size_t all = 0;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const std::size_t count = scenes[i].capture.frames.size();
    pictures[group[i]] += count;
    all += count;
    if (group[i] == i) order[sha256_hex("split " + std::to_string(scenes[i].number))] = i;
  }
  std::map<std::size_t, Split> side;
  std::array<double, 3> room = {0, shares[1] * static_cast<double>(all),
                                shares[2] * static_cast<double>(all)};
  std::size_t left = order.size();
  std::array<Split, 2> held_out = {Split::test, Split::val};
  if (left == 2 && needed == Split::val) std::swap(held_out[0], held_out[1]);
  for (const auto& [hash, first] : order) {
    const auto size = static_cast<double>(pictures[first]);
    Split chosen = Split::train;
    for (const Split split : held_out) {
      // A group goes where at least half of it has room; the last one is for training.
      double& here = room[static_cast<std::size_t>(split)];
      const bool is_first =
          here == shares[static_cast<std::size_t>(split)] * static_cast<double>(all);
      if (left == 1 || here <= 0 || (!is_first && here < 0.5 * size)) continue;
      here -= size;
      chosen = split;
      break;
    }
    // All may be asked to be test or val.
    if (left == 1 && shares[0] == 0) chosen = shares[2] > 0 ? Split::test : Split::val;
    side[first] = chosen;
    --left;
  }
  std::vector<Split> splits;
  for (const std::size_t first : group) splits.push_back(side[first]);
  return splits;
}

std::string empty_splits(const std::vector<Split>& splits, const std::array<double, 3>& shares) {
  std::string names;
  for (const Split split : kSplits) {
    const bool is_there = std::find(splits.begin(), splits.end(), split) != splits.end();
    if (is_there || shares[static_cast<std::size_t>(split)] == 0) continue;
    names += (names.empty() ? "" : " and ") + std::string(to_string(split));
  }
  if (names.empty()) return names;
  return names + (names.find(' ') == std::string::npos ? " is" : " are") +
         " empty: plants are never on two sides, and there are too few scenes of different plants; "
         "render more --scenes, or choose --split";
}

}  // namespace cousin
