#include <string>
#include <vector>

#include "scenes/fruit/rest_text.h"
#include "scenes/strawberries/strawberry_stand.h"

namespace cousin {
namespace {

constexpr std::string_view kHeader = "cousin strawberry stand at rest 1";

/// Nodes of each stalk that a stand of this stream has.
std::vector<int> stalk_nodes(const StandConfig& config, const StrawberryBedConfig& bed,
                             const Rng& rng) {
  std::vector<int> nodes;
  const Stand stand = draw_stand(config, bed, rng);
  for (std::size_t i = 0; i < stand.trusses.size(); ++i) {
    const BendingPlant stalks = grow_stalks(stand.trusses[i], truss_rng(rng, i));
    for (const BendingStem& stem : stalks.stems) nodes.push_back(stem.segments + 1);
  }
  return nodes;
}

}  // namespace

std::string to_text(const StandRest& rest) {
  return std::string(kHeader) + "\nattempt " + std::to_string(rest.attempt) + "\n" +
         sag_text(rest.sag) + "end\n";
}

std::string description(const StandConfig& config, const StrawberryBedConfig& bed) {
  StandConfig stand = config;
  StrawberryBedConfig copy = bed;
  SagConfig settling = truss_sag();
  std::string text =
      std::string(kHeader) + "\n" + to_toml(fields(stand)) + to_toml(fields(settling));
  for (const Field& field : fields(copy)) {
    if (field.key.starts_with("row.")) text += to_toml({field});
  }
  return text;
}

StandRest rest_from_text(std::string_view text, const std::string& name, const StandConfig& config,
                         const StrawberryBedConfig& bed, const Rng& rng) {
  RestWords words(text, name);
  words.expect(kHeader);
  StandRest rest;
  words.expect("attempt");
  rest.attempt = words.integer("attempt", 0, 100);
  // What must be there is what a stand of this stream has.
  rest.sag = read_sag(words, stalk_nodes(config, bed, attempt_rng(rng, rest.attempt)), 5e-4);
  words.expect("end");
  words.end();
  return rest;
}

}  // namespace cousin
