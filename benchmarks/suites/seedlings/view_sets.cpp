#include "benchmarks/suites/seedlings/view_sets.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace cousin {
namespace {

constexpr int kHeldOutEvery = 5;
constexpr int kFirstHeldOut = 2;

}  // namespace

bool is_held_out(int view) { return view % kHeldOutEvery == kFirstHeldOut; }

int planned_views(int trained) {
  int views = 0;
  for (int left = trained; left > 0; ++views) left -= !is_held_out(views);
  return views;
}

std::vector<int> drawn_views(int all, int count, Rng rng) {
  if (count < 1 || count > all) {
    throw std::invalid_argument(std::to_string(count) + " views are not in 1.." +
                                std::to_string(all));
  }
  std::vector<int> order(static_cast<std::size_t>(all));
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t i = order.size(); i > 1; --i)
    std::swap(order[i - 1], order[uniform_index(rng, i)]);
  order.resize(static_cast<std::size_t>(count));
  std::sort(order.begin(), order.end());
  return order;
}

}  // namespace cousin
