#pragma once

#include <stdexcept>

namespace cousin {

/// What is asked for is not in this build of the program: wrong usage, wherever it shows.
class NotBuilt : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

}  // namespace cousin
