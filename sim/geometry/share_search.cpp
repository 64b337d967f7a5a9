#include "sim/geometry/share_search.h"

#include <algorithm>
#include <cmath>

namespace cousin {
namespace {

struct Tried {
  Eigen::VectorXd at;
  double off = 0;  ///< share less what is wanted
};

struct Pair {
  std::size_t low, high;
  double apart;
};

/// Pairs of places on either side of the wanted share, the nearest first.
std::vector<Pair> pairs_of(const std::vector<Tried>& tried) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < tried.size(); ++i) {
    for (std::size_t k = 0; k < tried.size(); ++k) {
      if (tried[i].off < 0 && tried[k].off > 0)
        pairs.push_back({i, k, (tried[i].at - tried[k].at).norm()});
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.apart < b.apart; });
  return pairs;
}

}  // namespace

ShareFound find_share(const std::vector<Eigen::VectorXd>& starts,
                      const std::function<double(const Eigen::VectorXd&)>& share,
                      const ShareSearch& search) {
  ShareFound found;
  double least = std::numeric_limits<double>::infinity();
  // The share's distance from what is wanted; keeps the best.
  const auto off_at = [&](const Eigen::VectorXd& at) {
    ++found.tried;
    const double value = share(at), off = value - search.wanted;
    if (std::isnan(value) || !(std::abs(off) < least)) return off;
    least = std::abs(off);
    found.at = at;
    found.share = value;
    found.met = least <= search.tolerance;
    return off;
  };
  std::vector<Tried> tried;
  for (const Eigen::VectorXd& start : starts) {
    const double off = off_at(start);
    if (found.met) return found;
    if (!std::isnan(off)) tried.push_back({start, off});
  }
  int pairs = 0;
  for (const Pair& pair : pairs_of(tried)) {
    if (pairs++ == search.pairs) break;
    Eigen::VectorXd low = tried[pair.low].at, high = tried[pair.high].at;
    for (int step = 0; step < search.steps; ++step) {
      const Eigen::VectorXd middle = 0.5 * (low + high);
      const double off = off_at(middle);
      if (found.met) return found;
      if (std::isnan(off)) break;
      (off < 0 ? low : high) = middle;
    }
  }
  return found;
}

}  // namespace cousin
