#include "scenes/fruit/leaf_search.h"

#include <limits>

namespace cousin {

MovedLeaves move_leaves(const Scene& scene, const std::vector<MovableLeaf>& leaves,
                        std::size_t target, const TrueView& view, double reach_m, double wanted) {
  std::vector<std::size_t> places;
  for (const MovableLeaf& leaf : leaves) places.push_back(leaf.place);
  const VisibleShare visible(scene, target, reach_m, places);
  const auto count = static_cast<Eigen::Index>(leaves.size());
  // One leaf after the other, each as far as it goes.
  std::vector<Eigen::VectorXd> starts = {Eigen::VectorXd::Zero(count)};
  for (Eigen::Index k = 0; k < count; ++k) {
    starts.push_back(starts.back());
    starts.back()[k] = 1;
  }
  const auto moved = [&](const Eigen::VectorXd& shares) {
    std::vector<MovedInstance> list;
    for (Eigen::Index k = 0; k < count; ++k) {
      const MovableLeaf& leaf = leaves[static_cast<std::size_t>(k)];
      if (shares[k] > 0) list.push_back({leaf.place, leaf.pose_at(shares[k])});
    }
    return list;
  };
  MovedLeaves result;
  result.found =
      find_share(starts,
                 [&](const Eigen::VectorXd& shares) {
                   for (Eigen::Index k = 0; k < count; ++k) {
                     if (shares[k] > 0 && !leaves[static_cast<std::size_t>(k)].is_free(shares[k]))
                       return std::numeric_limits<double>::quiet_NaN();
                   }
                   return visible.seen(view, moved(shares));
                 },
                 {.wanted = wanted});
  if (result.found.at.size() == count) result.moved = moved(result.found.at);
  return result;
}

}  // namespace cousin
