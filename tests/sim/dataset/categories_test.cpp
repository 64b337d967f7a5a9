#include "sim/dataset/categories.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/dataset/atomic_file.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

/// What reading a folder with this categories.json says; "" if it is read.
std::string refusal_of(const std::string& text) {
  const TemporaryFolder folder;
  write_file(folder.path() / kCategoriesFile, text);
  try {
    read_categories(folder.path());
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(Categories, AreReadAsTheyWereWrittenAndAFolderWithoutHasNone) {
  const TemporaryFolder folder;
  EXPECT_TRUE(read_categories(folder.path()).empty());
  write_categories(folder.path(), {"high", "low", "red \"and\" green"});
  EXPECT_THAT(read_categories(folder.path()),
              testing::ElementsAre("high", "low", "red \"and\" green"));
}

TEST(Categories, CocosSupercategoryMayStandBeside) {
  const TemporaryFolder folder;
  write_file(folder.path() / kCategoriesFile,
             R"([{"id": 1, "name": "ripe", "supercategory": "fruit"}])");
  EXPECT_THAT(read_categories(folder.path()), testing::ElementsAre("ripe"));
}

TEST(Categories, ALinkOutOfTheFolderIsNotFollowed) {
  const TemporaryFolder folder, other;
  write_categories(other.path(), {"ripe"});
  std::filesystem::create_symlink(other.path() / kCategoriesFile, folder.path() / kCategoriesFile);
  EXPECT_THROW(read_categories(folder.path()), std::runtime_error);
}

TEST(Categories, NumbersWithAGapAndNamesTwiceAreRefused) {
  using testing::HasSubstr;
  EXPECT_THAT(refusal_of(R"([{"id": 0, "name": "a"}])"), HasSubstr("/0/id"));
  EXPECT_THAT(refusal_of(R"([{"id": 1, "name": "a"}, {"id": 3, "name": "b"}])"),
              HasSubstr("without a gap"));
  EXPECT_THAT(refusal_of(R"([{"id": 1, "name": "a"}, {"id": 2, "name": "a"}])"),
              HasSubstr("stands twice"));
  EXPECT_THAT(refusal_of(R"([{"id": 1, "name": ""}])"), HasSubstr("is empty"));
  EXPECT_THAT(refusal_of(R"([{"id": 1, "name": "a", "keypoints": []}])"), HasSubstr("keypoints"));
  EXPECT_THAT(refusal_of(R"({"id": 1})"), HasSubstr(kCategoriesFile));
}

}  // namespace
}  // namespace cousin
