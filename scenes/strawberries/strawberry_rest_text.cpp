#include <charconv>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "scenes/strawberries/strawberry_stand.h"

namespace cousin {
namespace {

constexpr std::string_view kHeader = "cousin strawberry stand at rest 1";
constexpr double kFar_m = 10;

void put(std::string& text, double value) {
  char number[40];
  std::snprintf(number, sizeof number, " %.17g", value);
  text += number;
}

/// Words of a text, one after another, each checked.
class Words {
 public:
  Words(std::string_view text, std::string name) : text_(text), name_(std::move(name)) {}

  void expect(std::string_view words) {
    std::size_t at = 0;
    while (at < words.size()) {
      const std::size_t end = std::min(words.find(' ', at), words.size());
      const std::string_view wanted = words.substr(at, end - at);
      const std::string_view found = next();
      if (found != wanted)
        fail("\"" + std::string(found.substr(0, 40)) + "\" stands where \"" + std::string(wanted) +
             "\" must");
      at = end + 1;
    }
  }
  double number(const char* what, double low, double high) {
    const std::string_view word = next();
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(value))
      fail(std::string(what) + " \"" + std::string(word.substr(0, 40)) + "\" is no finite number");
    if (value < low || value > high)
      fail(std::string(what) + " is " + std::to_string(value) + "; it must be in [" +
           std::to_string(low) + ", " + std::to_string(high) + "]");
    return value;
  }
  int integer(const char* what, int low, int high) {
    const double value = number(what, low, high);
    if (value != std::floor(value))
      fail(std::string(what) + " is " + std::to_string(value) + ", not whole");
    return static_cast<int>(value);
  }
  void end() {
    if (!next().empty()) fail("more stands after its end");
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(name_ + ": " + what);
  }

 private:
  std::string_view next() {
    constexpr std::string_view kSpace = " \n";
    const std::size_t begin = std::min(text_.find_first_not_of(kSpace, at_), text_.size());
    at_ = std::min(text_.find_first_of(kSpace, begin), text_.size());
    return text_.substr(begin, at_ - begin);
  }

  std::string_view text_;
  std::string name_;
  std::size_t at_ = 0;
};

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

Pose read_pose(Words& words) {
  Pose pose;
  const double w = words.number("a rotation", -1.001, 1.001);
  const double x = words.number("a rotation", -1.001, 1.001);
  const double y = words.number("a rotation", -1.001, 1.001);
  const double z = words.number("a rotation", -1.001, 1.001);
  pose.rotation = Eigen::Quaterniond(w, x, y, z);
  if (std::abs(pose.rotation.norm() - 1) > 1e-9)
    words.fail("a rotation's norm is " + std::to_string(pose.rotation.norm()) +
               "; it must be 1 to 1e-9");
  for (int k = 0; k < 3; ++k) pose.translation_m[k] = words.number("a place", -kFar_m, kFar_m);
  return pose;
}

}  // namespace

std::string to_text(const StandRest& rest) {
  const SagResult& sag = rest.sag;
  std::string text = std::string(kHeader) + "\nattempt " + std::to_string(rest.attempt) + "\nsag";
  for (const double value :
       {sag.time_s, sag.moved_m, sag.max_penetration_m, sag.strain.stress_pa, sag.strain.ratio,
        static_cast<double>(sag.strain.stem), sag.strain.share})
    put(text, value);
  text += "\nstems " + std::to_string(sag.bent.sections.size()) + "\n";
  for (std::size_t s = 0; s < sag.bent.sections.size(); ++s) {
    text += "stem " + std::to_string(sag.bent.sections[s].size()) + "\n";
    for (const Pose& pose : sag.bent.sections[s]) {
      const Eigen::Quaterniond& q = pose.rotation;
      for (const double value : {q.w(), q.x(), q.y(), q.z()}) put(text, value);
      for (int k = 0; k < 3; ++k) put(text, pose.translation_m[k]);
      text += "\n";
    }
    for (const double angle : sag.bent.joints_rad[s]) put(text, angle);
    text += "\n";
  }
  return text + "end\n";
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
  Words words(text, name);
  words.expect(kHeader);
  StandRest rest;
  words.expect("attempt");
  rest.attempt = words.integer("attempt", 0, 100);
  words.expect("sag");
  SagResult& sag = rest.sag;
  sag.status = PlantStatus::ok;
  sag.time_s = words.number("time", 0, 1e4);
  sag.moved_m = words.number("motion", 0, 1);
  sag.max_penetration_m = words.number("overlap", 0, 5e-4);
  sag.strain.stress_pa = words.number("stress", 0, 1e12);
  sag.strain.ratio = words.number("strain", 0, 1);
  sag.strain.stem = words.integer("strained stem", -1, 4000);
  sag.strain.share = words.number("strained share", 0, 1);
  // What must be there is what a stand of this stream has.
  const std::vector<int> nodes = stalk_nodes(config, bed, attempt_rng(rng, rest.attempt));
  words.expect("stems");
  if (words.integer("number of stems", 0, 4000) != static_cast<int>(nodes.size()))
    words.fail("it is of another stand, which has not " + std::to_string(nodes.size()) + " stems");
  for (std::size_t s = 0; s < nodes.size(); ++s) {
    words.expect("stem");
    if (words.integer("number of nodes", 2, 401) != nodes[s])
      words.fail("stem " + std::to_string(s) + " has not " + std::to_string(nodes[s]) + " nodes");
    std::vector<Pose> sections;
    for (int node = 0; node < nodes[s]; ++node) sections.push_back(read_pose(words));
    sag.bent.sections.push_back(std::move(sections));
    std::vector<double> angles_rad;
    for (int k = 0; k < 3 * (nodes[s] - 1); ++k)
      angles_rad.push_back(words.number("an angle", -100, 100));
    sag.bent.joints_rad.push_back(std::move(angles_rad));
  }
  words.expect("end");
  words.end();
  return rest;
}

}  // namespace cousin
