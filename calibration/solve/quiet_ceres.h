#pragma once

// Private to the files that call Ceres.

#include <glog/logging.h>

#include <algorithm>

namespace cousin {

/// Ceres warns of steps that fail, which are part of a search here: only errors are printed.
inline void quiet_warnings() {
  static const bool done = [] {
    FLAGS_minloglevel = std::max(FLAGS_minloglevel, static_cast<int>(google::GLOG_ERROR));
    return true;
  }();
  (void)done;
}

}  // namespace cousin
