#pragma once

#include <array>
#include <string>
#include <vector>

#include "sim/config/fields.h"

namespace cousin {

/// `ordered` looks at the order in which the images were taken alone; `exhaustive` takes all.
enum class PairChoice { ordered, exhaustive };
std::string_view to_string(PairChoice choice);

struct PairConfig {
  PairChoice choice = PairChoice::ordered;
  int neighbours = 3;          ///< each image with so many after it
  bool ring = true;            ///< the last images' neighbours are the first
  double far_per_image = 2.0;  ///< far pairs over images: all pairs of evenly spaced images
};
Fields fields(PairConfig& config);
void validate(const PairConfig& config);

/// Two images by their place in the order, the lower first.
using ImagePair = std::array<int, 2>;

/// Which images to match, ascending, each pair once. In order, a path that comes back to where it
/// was (rings at several heights, a spiral) is closed by far pairs: as many evenly spaced images as
/// give `far_per_image` times `images` pairs, each with each. So the pairs grow with the images and
/// not with their square.
/// @throws std::invalid_argument if the config is not valid or `images` is negative
std::vector<ImagePair> image_pairs(int images, const PairConfig& config = {});

/// All pairs with an image that has no place yet, without those that were matched; ascending.
/// @param placed  images with a place, in any order, as `matched` is
std::vector<ImagePair> pairs_of_lost(int images, const std::vector<int>& placed,
                                     const std::vector<ImagePair>& matched);

}  // namespace cousin
