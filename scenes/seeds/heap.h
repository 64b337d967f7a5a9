#pragma once

#include <vector>

#include "scenes/seeds/placing.h"

namespace cousin {

/// Specimens that lie on one another. Private to scenes/seeds.
struct Heap {
  std::vector<Pose> world_from_specimen;
  std::vector<double>
      visible;                ///< of each: share of its image that others leave free, mean of views
  std::vector<int> touching;  ///< of each: how many others it touches, within 0.1 mm
};

/// Pours the specimens, one after the other from a small height, over a disc whose radius is
/// searched by bisection until the mean of `visible` is within 0.02 of `visible_fraction`, or at
/// last 0.03. It is reckoned in up to 20 of the views, by a camera that looks where they look.
/// @throws std::runtime_error naming what was asked and what was reached, if the wish cannot be
/// met; or that MuJoCo is not built in.
Heap drop_heap(const std::vector<BoardSpecimen>& specimens, const SettingConfig& setting,
               const std::vector<View>& views, double visible_fraction, Rng rng);

/// Share of each instance's image that the others leave free, mean over the views in which it has
/// one. @param scene  of nothing but specimens
std::vector<double> visible_fractions(const Scene& scene, const std::vector<View>& views);

}  // namespace cousin
