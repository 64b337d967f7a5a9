#include "sim/dataset/links.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/dataset/atomic_file.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {
namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class Links : public testing::Test {
 protected:
  Links() {
    write_file(folder("data/000000/rgb/000000.png"), "a picture");
    write_file(folder("secret/key"), "not theirs");
  }
  fs::path folder(const std::string& below) const { return folder_.path() / below; }
  std::string refusal(const fs::path& part, const fs::path& without = {}) const {
    return error_of([&] { refuse_links_out(folder("data"), part, without); });
  }
  TemporaryFolder folder_;
};

TEST_F(Links, AFolderWithoutLinksPasses) {
  EXPECT_EQ(refusal("000000"), "");
  EXPECT_EQ(refusal("."), "");
  EXPECT_EQ(refusal("there is no such part"), "");
}

TEST_F(Links, AFileThatLeadsOutIsNamedWithWhereItLeads) {
  fs::create_symlink(folder("secret/key"), folder("data/000000/rgb/000001.png"));
  EXPECT_THAT(refusal("000000"),
              AllOf(HasSubstr("rgb/000001.png"), HasSubstr("secret/key"), HasSubstr("outside")));
}

TEST_F(Links, AFolderThatLeadsOutIsRefused) {
  fs::create_directory_symlink("../../secret", folder("data/000000/depth"));
  EXPECT_THAT(refusal("000000"), HasSubstr("depth"));
  EXPECT_EQ(refusal("000000", "depth"), "") << "a part that nobody reads may lead anywhere";
}

TEST_F(Links, APartThatIsItselfALinkOutIsRefused) {
  fs::create_directory_symlink(folder("secret"), folder("data/000001"));
  EXPECT_THAT(refusal("000001"), HasSubstr("000001"));
}

TEST_F(Links, ALinkThatLeadsNowhereOutsideIsRefused) {
  fs::create_symlink("/no/such/file", folder("data/000000/rig.json"));
  EXPECT_THAT(refusal("000000"), HasSubstr("rig.json"));
}

TEST_F(Links, ALinkWithinTheFolderPassesAndItsTargetIsLookedAt) {
  fs::create_directory_symlink("../000000/rgb", folder("data/000000/rgb_again"));
  fs::create_directory_symlink("..", folder("data/000000/loop"));
  EXPECT_EQ(refusal("000000"), "");
  fs::create_symlink(folder("secret/key"), folder("data/other"));
  EXPECT_THAT(refusal("000000"), HasSubstr("other")) << "by way of the loop";
}

TEST_F(Links, TheFolderItselfMayBeALink) {
  fs::create_directory_symlink(folder("data"), folder("here"));
  EXPECT_EQ(error_of([&] { refuse_links_out(folder("here"), "000000"); }), "");
}

}  // namespace
}  // namespace cousin
