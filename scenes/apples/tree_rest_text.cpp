#include <stdexcept>

#include "scenes/apples/apples_scene.h"
#include "scenes/fruit/rest_text.h"

namespace cousin {
namespace {

constexpr std::string_view kHeader = "cousin apple branches at rest 1";
constexpr double kMostOverlap_m = 0.1;  // what overlaps is pruned or thinned once it hangs

bool starts_with_any(std::string_view key, std::initializer_list<std::string_view> prefixes) {
  for (const std::string_view prefix : prefixes) {
    if (key.starts_with(prefix)) return true;
  }
  return false;
}

}  // namespace

std::string rests_to_text(const std::vector<SagResult>& rests) {
  std::string text = std::string(kHeader) + "\nbranches " + std::to_string(rests.size()) + "\n";
  for (const SagResult& sag : rests) {
    text += sag.status == PlantStatus::not_at_rest ? "moves " : "rests ";
    text += sag_text(sag);
  }
  return text + "end\n";
}

std::vector<SagResult> rests_from_text(std::string_view text, const std::string& name,
                                       const std::vector<HangingBranch>& branches) {
  RestWords words(text, name);
  words.expect(kHeader);
  words.expect("branches");
  if (words.integer("number of branches", 0, 1000) != static_cast<int>(branches.size()))
    words.fail("it is of another tree, which has not " + std::to_string(branches.size()) +
               " branches");
  std::vector<SagResult> rests;
  for (const HangingBranch& branch : branches) {
    const bool rests_now = words.either("rests", "moves");
    std::vector<int> nodes;
    for (const BendingStem& stem : branch.plant.stems) nodes.push_back(stem.segments + 1);
    rests.push_back(read_sag(words, nodes, kMostOverlap_m));
    if (!rests_now) rests.back().status = PlantStatus::not_at_rest;
  }
  words.expect("end");
  words.end();
  return rests;
}

std::string description_of_tree(const ApplesSceneConfig& config) {
  ApplesSceneConfig copy = config;
  SagConfig settling;
  Fields decisive;
  for (Field& field : fields(copy)) {
    // What stands beside the tree, and how it is looked at.
    if (starts_with_any(field.key, {"neighbours", "trees", "rows", "light", "views", "look",
                                    "distance_", "occlusion", "turns_leaves", "unmet", "wind",
                                    "gusts.", "push.", "rig", "orchard.ground.", "orchard.light.",
                                    "orchard.views.", "orchard.wood.", "orchard.sway."}))
      continue;
    decisive.push_back(std::move(field));
  }
  return std::string(kHeader) + "\n" + to_toml(decisive) + to_toml(fields(settling));
}

}  // namespace cousin
