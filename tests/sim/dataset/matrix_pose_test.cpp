#include "sim/dataset/matrix_pose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(PoseOfText, ReadsFourRows) {
  const auto pose = pose_of_text("0 -1 0 1e-001\n1 0 0 2\n0 0 1 3\n\n0 0 0 1\n", "p.txt");
  ASSERT_TRUE(pose);
  EXPECT_LT((*pose * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0.1, 3, 3)).norm(), 1e-12);
}

TEST(PoseOfText, AnInfinitePoseIsNone) {
  EXPECT_FALSE(pose_of_text("-inf 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "p.txt"));
  EXPECT_FALSE(pose_of_text("nan nan nan nan\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "p.txt"));
}

TEST(PoseOfText, DigitsThatAreLeftAwayAreMadeUpFor) {
  const auto pose = pose_of_text(
      "0.7035 0.3191 -0.6349 0\n-0.3710 0.9270 0.0548 0\n"
      "0.6061 0.1970 0.7705 0\n0 0 0 1\n",
      "p.txt");
  ASSERT_TRUE(pose);
  EXPECT_NEAR(pose->rotation.norm(), 1, 1e-12);
}

TEST(PoseOfText, WhatIsNoPoseIsRefused) {
  const auto error = [](const std::string& text) {
    return error_of([&] { pose_of_text(text, "p.txt"); });
  };
  EXPECT_THAT(error("1 0 0 0\n"), HasSubstr("p.txt: has 1 rows, not 4"));
  EXPECT_THAT(error("1 0 0 0\n0 1 0\n0 0 1 0\n0 0 0 1\n"),
              HasSubstr("p.txt: line 2: has 3 words, not 4"));
  EXPECT_THAT(error("1 0 0 0\n0 1 0 x\n0 0 1 0\n0 0 0 1\n"), HasSubstr("line 2: word 4"));
  EXPECT_THAT(error("1.001 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"),
              AllOf(HasSubstr("not a rotation"), HasSubstr("0.002"), HasSubstr("limit is 1e-3")));
  EXPECT_THAT(error("-1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"), HasSubstr("mirrors"));
  EXPECT_THAT(error("1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 1 1\n"), HasSubstr("last row"));
  EXPECT_THAT(error("1 0 0 2e9\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"), HasSubstr("beyond 1e9"));
}

}  // namespace
}  // namespace cousin
