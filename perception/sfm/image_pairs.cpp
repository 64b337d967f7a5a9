#include "perception/sfm/image_pairs.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "sim/config/limits.h"

namespace cousin {
namespace {

TextField choice_field(PairChoice& choice) {
  return {[&choice] { return std::string(to_string(choice)); },
          [&choice](const std::string& text) {
            for (const PairChoice each : {PairChoice::ordered, PairChoice::exhaustive}) {
              if (text == to_string(each)) {
                choice = each;
                return;
              }
            }
            throw std::invalid_argument("pairs \"" + text + "\" is not ordered or exhaustive");
          }};
}

/// So many that all pairs of them are at least `pairs`; at most `images`.
int images_for(double pairs, int images) {
  const double wanted = std::ceil(0.5 + std::sqrt(0.25 + 2 * pairs));
  return std::min(images, static_cast<int>(std::min(wanted, 1e9)));
}

}  // namespace

std::string_view to_string(PairChoice choice) {
  return choice == PairChoice::ordered ? "ordered" : "exhaustive";
}

Fields fields(PairConfig& config) {
  return {
      {"choice", choice_field(config.choice), "ordered or exhaustive"},
      {"neighbours", &config.neighbours, "each image is matched with so many after it", 1, 1000},
      {"ring", &config.ring, "the last images' neighbours are the first"},
      {"far_per_image", &config.far_per_image,
       "far pairs over images: all pairs of evenly spaced images", 0, 1000}};
}

void validate(const PairConfig& config) {
  PairConfig copy = config;  // fields point into what they describe
  check_limits(fields(copy));
}

std::vector<ImagePair> image_pairs(int images, const PairConfig& config) {
  validate(config);
  if (images < 0) throw std::invalid_argument("image_pairs: " + std::to_string(images) + " images");
  std::set<ImagePair> pairs;
  const auto add = [&](int a, int b) {
    if (a != b) pairs.insert({std::min(a, b), std::max(a, b)});
  };
  if (config.choice == PairChoice::exhaustive) {
    for (int a = 0; a < images; ++a) {
      for (int b = a + 1; b < images; ++b) add(a, b);
    }
    return {pairs.begin(), pairs.end()};
  }
  for (int a = 0; a < images; ++a) {
    for (int d = 1; d <= config.neighbours && d < images; ++d) {
      if (a + d < images || config.ring) add(a, (a + d) % images);
    }
  }
  const int far = config.far_per_image > 0 ? images_for(config.far_per_image * images, images) : 0;
  const auto place = [&](int i) {
    return static_cast<int>(static_cast<long long>(i) * images / far);
  };
  for (int i = 0; i < far; ++i) {
    for (int k = i + 1; k < far; ++k) add(place(i), place(k));
  }
  return {pairs.begin(), pairs.end()};
}

std::vector<ImagePair> pairs_of_lost(int images, const std::vector<int>& placed,
                                     const std::vector<ImagePair>& matched) {
  const std::set<int> there(placed.begin(), placed.end());
  const std::set<ImagePair> done(matched.begin(), matched.end());
  std::vector<ImagePair> pairs;
  for (int a = 0; a < images; ++a) {
    for (int b = a + 1; b < images; ++b) {
      const bool both = there.contains(a) && there.contains(b);
      if (!both && !done.contains({a, b})) pairs.push_back({a, b});
    }
  }
  return pairs;
}

}  // namespace cousin
