#pragma once

#include "perception/stem/stem_fit.h"

namespace cousin {

/// Nodes as a fit of fits.json, "stem": node_I_x, _y, _z, _along (m); node 0 is the root if
/// `has_root` is 1.
ObjectFit stem_as_fit(const StemNodes& nodes, int instance, bool has_root);
/// The converse. @throws std::invalid_argument for a fit of another model or without nodes
struct FittedStem {
  StemNodes nodes;
  bool has_root = false;
};
FittedStem stem_of_fit(const ObjectFit& fit);

}  // namespace cousin
