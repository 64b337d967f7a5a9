#pragma once

#include <string>
#include <utility>
#include <vector>

namespace cousin {

/// Which of a capture's images and which stages a configuration reads; what is not listed is left
/// out.
struct PipelineNeeds {
  std::vector<std::string> images;  ///< of "color", "raw", "infrared", "depth"
  std::vector<std::string> stages;
  std::vector<std::pair<std::string, std::string>> left_out;  ///< stage, why
};

}  // namespace cousin
