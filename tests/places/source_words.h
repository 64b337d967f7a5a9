#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "tests/places/places.h"

namespace cousin {

/// Every number of a scene's TOML file says where it comes from.
/// @param file  below scenes/
inline void expect_sourced(const std::string& file) {
  std::ifstream in(source_folder() / "scenes" / file);
  int numbers = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("#") || line.find(" = ") == line.npos) continue;
    ++numbers;
    EXPECT_TRUE(line.find("# free") != line.npos || line.find("# sourced: ") != line.npos ||
                line.find("# fitted: ") != line.npos)
        << file << ": " << line;
  }
  EXPECT_GT(numbers, 30) << file;
}

}  // namespace cousin
