#include "perception/fruit/tree_yield.h"

#include <algorithm>
#include <cmath>

#include "sim/config/limits.h"

namespace cousin {
namespace {

double squared(double value) { return value * value; }

/// Fruits that no view shows, with the variance of all.
struct Unseen {
  double count = 0, variance = 0;
};

Unseen unseen_by(double once, double twice, int views) {
  if (views < 2) return {};
  const double a = static_cast<double>(views - 1) / views, more = twice + 1;
  const double pairs = once * (once - 1) / (2 * more);
  return {a * pairs, a * pairs + squared(a) * once * squared(2 * once - 1) / (4 * squared(more)) +
                         squared(a) * squared(once) * twice * squared(once - 1) /
                             (4 * squared(squared(more)))};
}

double count_of(std::span<const SeenFruit> fruits, int views) {
  return static_cast<double>(std::count_if(
      fruits.begin(), fruits.end(),
      [&](const SeenFruit& fruit) { return fruit.is_located && fruit.views == views; }));
}

}  // namespace

Fields fields(TreeYieldConfig& c) {
  return {{"along_m", &c.along_m, "place of the tree along its row, about the trunk", 0.01, 1000},
          {"across_m", &c.across_m, "and across, from alley to alley", 0.01, 1000},
          {"located_m", &c.located_m, "largest sigma of a fruit's place that is known", 1e-4, 10},
          {"common_share", &c.common_share, "of a fruit's variance, the same in all views", 0, 1},
          {"count_sigma", &c.count_sigma, "of the count: boxes joined wrongly, over it", 0, 1},
          {"mass_sigma", &c.mass_sigma, "of what all masses are off, over them", 0, 1}};
}

void validate(const TreeYieldConfig& config) {
  TreeYieldConfig copy = config;
  check_limits(fields(copy), "yield");
}

bool is_in_place(const Eigen::Vector3d& point_in_world_m, const TreeYieldConfig& config) {
  return std::abs(point_in_world_m.x()) < 0.5 * config.along_m &&
         std::abs(point_in_world_m.y()) < 0.5 * config.across_m;
}

FruitMeasure fused(std::span<const FruitMeasure> views, double common_share) {
  double weights = 0, sum = 0, least = std::numeric_limits<double>::infinity(), count = 0;
  for (const FruitMeasure& view : views) {
    if (!std::isfinite(view.value) || !(view.sigma > 0)) continue;
    const double variance = squared(view.sigma);
    weights += 1 / variance;
    sum += view.value / variance;
    least = std::min(least, variance);
    ++count;
  }
  if (count == 0) return {};
  const double mean = sum / weights;
  double spread = 0;
  for (const FruitMeasure& view : views) {
    if (std::isfinite(view.value) && view.sigma > 0)
      spread += squared((view.value - mean) / view.sigma);
  }
  const double more = count > 1 ? std::max(1.0, spread / (count - 1)) : 1;
  return {mean, std::sqrt(more * (common_share * least + (1 - common_share) / weights))};
}

TreeYield yield_of(std::span<const SeenFruit> fruits, int views, const TreeYieldConfig& config) {
  TreeYield tree;
  tree.seen = static_cast<int>(fruits.size());
  const Unseen unseen = unseen_by(count_of(fruits, 1), count_of(fruits, 2), views);
  const double seen = static_cast<double>(fruits.size());
  tree.count = {seen + unseen.count, 0};
  const double wrongly = config.count_sigma * tree.count.value;
  // Where chances differ the estimate is a lower bound, and where few are seen once by chance it is
  // far too small with a small variance: all of it is one sigma more.
  tree.count.sigma = std::sqrt(unseen.variance + squared(unseen.count) + squared(wrongly));
  double sum_kg = 0, variance = 0, squares = 0, measured = 0;
  for (const SeenFruit& fruit : fruits) {
    if (!std::isfinite(fruit.mass_kg.value)) continue;
    sum_kg += fruit.mass_kg.value;
    squares += squared(fruit.mass_kg.value);
    if (std::isfinite(fruit.mass_kg.sigma)) variance += squared(fruit.mass_kg.sigma);
    ++measured;
  }
  if (measured == 0) return tree;
  const double mean_kg = sum_kg / measured;
  const double spread_kg2 =  // of fruits about their mean; of one fruit as the kind's, a fifth
      measured > 1 ? std::max(0.0, (squares - measured * squared(mean_kg)) / (measured - 1))
                   : squared(0.2 * mean_kg);
  const double others = std::max(0.0, tree.count.value - measured);
  tree.yield_kg.value = mean_kg * tree.count.value;
  tree.yield_kg.sigma = std::sqrt(variance + spread_kg2 * (others + squared(others) / measured) +
                                  squared(mean_kg * tree.count.sigma) +
                                  squared(config.mass_sigma * tree.yield_kg.value));
  return tree;
}

}  // namespace cousin
