#include "sim/dataset/sealed_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/byte_reader.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLimit = 1000;

class SealedFileTest : public testing::Test {
 protected:
  void SetUp() override {
    file_ = fs::path(testing::TempDir()) /
            testing::UnitTest::GetInstance()->current_test_info()->name();
  }
  void TearDown() override { fs::remove(file_); }
  std::string why(const std::string& line, std::size_t limit = kLimit) const {
    try {
      (void)read_sealed(file_, line, "list", limit);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }
  fs::path file_;
};

TEST_F(SealedFileTest, NumbersComeBackAsTheyWere) {
  ByteWriter bytes;
  bytes.text = "a list 1\n";
  const float row[3] = {1.5F, -2, 3};
  bytes.add(std::int64_t{-7}).add(0.25).add(row, sizeof row);
  write_sealed(file_, bytes.text);
  const std::string body = read_sealed(file_, "a list 1", "list", kLimit);
  ByteReader reader(body, "list");
  EXPECT_EQ(reader.take<std::int64_t>(), -7);
  EXPECT_EQ(reader.take<double>(), 0.25);
  float back[3] = {};
  reader.take(back, sizeof back);
  EXPECT_THAT(back, testing::ElementsAreArray(row));
  EXPECT_EQ(reader.left(), 0u);
  EXPECT_THROW(reader.take<char>(), std::runtime_error);
}

TEST_F(SealedFileTest, EveryChangedOrMissingByteIsNoticed) {
  write_sealed(file_, "a list 1\nsome numbers");
  const std::string whole = read_file(file_);
  EXPECT_EQ(why("a list 1"), "");
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string other = whole;
    other[i] = static_cast<char>(other[i] ^ 4);
    write_file(file_, other);
    EXPECT_THAT(why("a list 1"), testing::HasSubstr(file_.string())) << i;
    write_file(file_, whole.substr(0, i));
    EXPECT_THAT(why("a list 1"), testing::HasSubstr(file_.string())) << i;
  }
}

TEST_F(SealedFileTest, AnotherKindOrALargeFileIsRefused) {
  write_sealed(file_, "a list 1\nsome numbers");
  EXPECT_THAT(why("a list 2"), testing::HasSubstr("not a list"));
  EXPECT_THAT(why("a list"), testing::HasSubstr("not a list"));
  EXPECT_THAT(why("a list 1", 50), testing::HasSubstr("50"));
}

}  // namespace
}  // namespace cousin
