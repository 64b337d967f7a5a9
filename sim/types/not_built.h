#pragma once

#include <stdexcept>

namespace cousin {

/// This build of the program lacks what the user asks for. The exit code is that of wrong usage.
class NotBuilt : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

}  // namespace cousin
