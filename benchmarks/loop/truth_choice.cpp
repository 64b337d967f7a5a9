#include "benchmarks/loop/truth_choice.h"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace cousin {
namespace {

struct Choice {
  std::string_view name;
  bool TruthNeeds::*need;
};
constexpr std::array<Choice, 14> kChoices = {{{"depth", &TruthNeeds::depth},
                                              {"normal", &TruthNeeds::normal},
                                              {"instance", &TruthNeeds::instance},
                                              {"part", &TruthNeeds::part},
                                              {"position", &TruthNeeds::position},
                                              {"coverage", &TruthNeeds::coverage},
                                              {"visibility", &TruthNeeds::visibility},
                                              {"shares", &TruthNeeds::shares},
                                              {"keypoints", &TruthNeeds::keypoints},
                                              {"leaf_area", &TruthNeeds::leaf_area},
                                              {"flow", &TruthNeeds::flow},
                                              {"disparity", &TruthNeeds::disparity},
                                              {"noise_free_depth", &TruthNeeds::noise_free_depth},
                                              {"invalid_reason", &TruthNeeds::invalid_reason}}};

std::string names() {
  std::string text;
  for (const Choice& choice : kChoices) text += std::string(choice.name) + ", ";
  return text + "all, none";
}

}  // namespace

TruthNeeds truth_there_is(const DeviceConfig& rig, const Streams& streams) {
  TruthNeeds needs;
  for (const Choice& choice : kChoices) needs.*choice.need = true;
  const auto* cameras = std::get_if<RigConfig>(&rig);
  needs.disparity = cameras && cameras->sensors.size() > 1;
  needs.noise_free_depth = needs.invalid_reason = streams.depth;
  return needs;
}

TruthNeeds default_truth(const Streams& streams) {
  TruthNeeds needs;
  needs.visibility = true;
  needs.noise_free_depth = needs.invalid_reason = streams.depth;
  return needs;
}

TruthNeeds truth_needs_from_string(std::string_view text, const TruthNeeds& there_is) {
  TruthNeeds needs;
  if (text == "none") return needs;
  if (text == "all") return there_is;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    const std::string_view word = text.substr(from, comma - from);
    const auto choice = std::find_if(kChoices.begin(), kChoices.end(),
                                     [&](const Choice& c) { return c.name == word; });
    if (choice == kChoices.end()) {
      const bool alone = word == "all" || word == "none";
      throw std::invalid_argument("--truth \"" + std::string(text) + "\": \"" + std::string(word) +
                                  (alone ? "\" stands alone" : "\" is not one of " + names()));
    }
    if (!(there_is.*(choice->need))) {
      throw std::invalid_argument("--truth \"" + std::string(text) + "\": \"" + std::string(word) +
                                  "\" is not what this capture has: it has " + to_string(there_is));
    }
    needs.*(choice->need) = true;
    from = comma + 1;
  }
  return needs;
}

TruthNeeds truth_needs_for(std::string_view format, TruthNeeds base) {
  const bool labels = format == "coco" || format == "yolo";
  if (!labels && format != "bop") {
    throw std::invalid_argument("--for \"" + std::string(format) +
                                "\" is not one of coco, yolo, bop; other formats need no truth");
  }
  base.visibility = base.instance = true;
  base.keypoints = base.keypoints || labels;
  return base;
}

std::vector<std::pair<std::string, bool>> truth_names(const TruthNeeds& needs) {
  std::vector<std::pair<std::string, bool>> names;
  for (const Choice& choice : kChoices) names.emplace_back(choice.name, needs.*choice.need);
  return names;
}

std::string to_string(const TruthNeeds& needs) {
  std::string text;
  for (const Choice& choice : kChoices) {
    if (needs.*choice.need) text += (text.empty() ? "" : ",") + std::string(choice.name);
  }
  return text.empty() ? "none" : text;
}

}  // namespace cousin
