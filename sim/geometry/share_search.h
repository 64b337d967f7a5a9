#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <vector>

namespace cousin {

/// A search for a place at which a share (of a fruit that is seen, of a seed that is covered) has a
/// wanted value.
struct ShareSearch {
  double wanted = 0.5;
  double tolerance = 0.015;
  int pairs = 8;   ///< of starts, one below and one above, that are searched between
  int steps = 14;  ///< halvings between such a pair
};

struct ShareFound {
  Eigen::VectorXd at;  ///< the best place; empty if no start is allowed
  double share = std::numeric_limits<double>::quiet_NaN();  ///< there
  bool met = false;                                         ///< within the tolerance
  int tried = 0;                                            ///< places
};

/// Tries the starts in their order and takes the first that meets the share; else halves the way
/// between starts on either side of it, the nearest pairs first. A share that jumps on the way, as
/// where a camera passes behind something, may be missed: `met` says so.
/// @param share  of a place; NaN: the place is not allowed
ShareFound find_share(const std::vector<Eigen::VectorXd>& starts,
                      const std::function<double(const Eigen::VectorXd&)>& share,
                      const ShareSearch& search);

}  // namespace cousin
