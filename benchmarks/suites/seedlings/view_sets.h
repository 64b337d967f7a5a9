#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/types/rng.h"

namespace cousin {

/// Which photographs of a sample are trained on.
struct ViewSet {
  std::string name;  ///< "20 views", in tables
  int views = 0;
  bool one_side = false;  ///< all within a part of the azimuths and of the tray
};

/// The share of azimuths and of the tray that views of one side are spread over.
inline constexpr double kOneSideShare = 0.35;

/// Whether a view of the plan is kept from training. Every fifth: the plan's places come from
/// radical inverses in bases 2 and 3, of which every second, third or fourth is one part of the
/// tray.
bool is_held_out(int view);
/// The number of planned views of which `trained` are not held out.
int planned_views(int trained);

/// `count` of `all` views by random, in order; of the same stream fewer are among more.
/// @throws std::invalid_argument if count is not in 1..all.
std::vector<int> drawn_views(int all, int count, Rng rng);

}  // namespace cousin
