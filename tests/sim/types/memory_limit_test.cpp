#include "sim/types/memory_limit.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();

class MemoryLimit : public ::testing::Test {
 protected:
  ~MemoryLimit() override { set_memory_limit(0); }
};

TEST_F(MemoryLimit, TheDefaultIsAtMostEightGibibytes) {
  EXPECT_GT(memory_limit_bytes(), std::uint64_t{1} << 27);
  EXPECT_LE(memory_limit_bytes(), std::uint64_t{8} << 30);
}

TEST_F(MemoryLimit, WhatFitsPassesAndOneByteMoreDoesNot) {
  set_memory_limit(1000);
  EXPECT_NO_THROW(check_memory("a.png", 1000, "the image"));
  EXPECT_THROW(check_memory("a.png", 1001, "the image"), std::runtime_error);
}

TEST_F(MemoryLimit, TheMessageNamesTheFileTheBytesAndTheLimit) {
  set_memory_limit(std::uint64_t{1} << 30);
  try {
    check_memory("set/rgb.txt", std::uint64_t{3} << 30, "300 images");
    FAIL() << "not refused";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()),
              "set/rgb.txt: 300 images would take 3221225472 bytes (3.00 GiB) of memory; the limit "
              "is 1073741824 bytes (1.00 GiB), set by --memory-limit");
  }
}

TEST_F(MemoryLimit, SizesThatOverflowAreRefusedAndDoNotWrapAround) {
  EXPECT_EQ(bytes_times(std::uint64_t{1} << 33, std::uint64_t{1} << 33), kLargest);
  EXPECT_EQ(bytes_times(0, kLargest), 0U);
  EXPECT_EQ(bytes_times(3, 5), 15U);
  EXPECT_EQ(bytes_plus(kLargest - 1, 2), kLargest);
  EXPECT_EQ(bytes_plus(1, 2), 3U);
  EXPECT_THROW(check_memory("a.exr", bytes_times(kLargest, 2), "the image"), std::runtime_error);
}

}  // namespace
}  // namespace cousin
