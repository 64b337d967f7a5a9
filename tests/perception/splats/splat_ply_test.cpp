#include "perception/splats/splat_ply.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>

#include "sim/dataset/atomic_file.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

using ::testing::HasSubstr;

/// A file of its own for each test.
std::filesystem::path scratch_file() {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  return std::filesystem::path(::testing::TempDir()) / (std::string(test->name()) + ".ply");
}

SplatModel random_model(int degree, int count) {
  Rng rng(7);
  SplatModel model;
  model.sh_degree = degree;
  model.origin_in_world_m = {431234.1234567890123, -5412345.1, 1.0 / 3.0};
  const auto value = [&] { return static_cast<float>(uniform(rng, -3, 3)); };
  const std::size_t rest = static_cast<std::size_t>((degree + 1) * (degree + 1) - 1);
  for (int i = 0; i < count; ++i) {
    Splat splat;
    for (int k = 0; k < 3; ++k) splat.centre_m[k] = value();
    for (int k = 0; k < 3; ++k) splat.log_scale[k] = value();
    for (int k = 0; k < 4; ++k) splat.rotation_wxyz[k] = value();
    splat.opacity_logit = value();
    for (float& c : splat.sh_dc) c = value();
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < rest; ++k) splat.sh_rest[15 * c + k] = value();
    }
    model.splats.push_back(splat);
  }
  return model;
}

void expect_same(const Splat& a, const Splat& b) {
  EXPECT_EQ(a.centre_m, b.centre_m);
  EXPECT_EQ(a.log_scale, b.log_scale);
  EXPECT_EQ(a.rotation_wxyz, b.rotation_wxyz);
  EXPECT_EQ(a.opacity_logit, b.opacity_logit);
  EXPECT_EQ(a.sh_dc, b.sh_dc);
  EXPECT_EQ(a.sh_rest, b.sh_rest);
}

/// The message that reading ends with; empty if it does not throw.
std::string error_of(const std::string& bytes, const SplatPlyConfig& config = {}) {
  const std::filesystem::path file = scratch_file();
  write_file(file, bytes);
  try {
    read_splat_ply(file, config);
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr(file.string()));
    return error.what();
  }
  return {};
}

std::string text_file(const std::string& properties, const std::string& rows, int count = 1,
                      const std::string& comment = "") {
  std::istringstream names(properties);
  std::string text =
      "ply\nformat ascii 1.0\n" + comment + "element vertex " + std::to_string(count) + "\n";
  for (std::string name; names >> name;) text += "property float " + name + "\n";
  return text + "end_header\n" + rows;
}

const std::string kDegreeZero =
    "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3";
const std::string kRow = "1 2 3 .1 .2 .3 4 -1 -2 -3 1 0 0 0\n";

TEST(SplatPly, WhatIsWrittenIsReadBitByBit) {
  for (int degree = 0; degree <= 3; ++degree) {
    SplatModel model = random_model(degree, 50);
    model.low_pass_px2 = 0.03 + degree;
    write_splat_ply(scratch_file(), model);
    const SplatFile file = read_splat_ply(scratch_file());
    EXPECT_EQ(file.model.sh_degree, degree);
    EXPECT_EQ(file.model.origin_in_world_m, model.origin_in_world_m);
    EXPECT_EQ(file.model.low_pass_px2, model.low_pass_px2);
    EXPECT_EQ(file.not_finite, 0u);
    EXPECT_EQ(file.zero_rotations, 0u);
    ASSERT_EQ(file.model.splats.size(), model.splats.size());
    for (std::size_t i = 0; i < model.splats.size(); ++i)
      expect_same(file.model.splats[i], model.splats[i]);
  }
}

TEST(SplatPly, TheLayoutIsTheReferences) {
  const SplatModel model = random_model(3, 1);
  write_splat_ply(scratch_file(), model);
  const std::string bytes = read_file(scratch_file());
  std::string names;
  std::istringstream header(bytes);
  int number = 0;
  for (std::string line; std::getline(header, line) && line != "end_header";) {
    if (line.starts_with("property float ")) names += line.substr(15) + " ";
    // The reference's viewer reads the first three lines by their place, then the properties.
    ++number;
    if (number == 3) EXPECT_EQ(line, "element vertex 1");
    if (number > 3 && number <= 3 + 62) EXPECT_TRUE(line.starts_with("property float ")) << line;
  }
  std::string expected = "x y z nx ny nz f_dc_0 f_dc_1 f_dc_2 ";
  for (int i = 0; i < 45; ++i) expected += "f_rest_" + std::to_string(i) + " ";
  EXPECT_EQ(names, expected + "opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3 ");
  // 62 floats end the file; the 16th of f_rest is the first of green.
  ASSERT_GT(bytes.size(), 62 * sizeof(float));
  std::array<float, 62> row{};
  std::memcpy(row.data(), bytes.data() + bytes.size() - sizeof row, sizeof row);
  EXPECT_EQ(row[0], model.splats[0].centre_m.x());
  EXPECT_EQ(row[9 + 15], model.splats[0].sh_rest[15]);
  EXPECT_EQ(row[54], model.splats[0].opacity_logit);
  EXPECT_EQ(row[58], model.splats[0].rotation_wxyz[0]);
}

TEST(SplatPly, TextInAnyOrderWithOtherPropertiesAndElementsIsRead) {
  const std::string text =
      "ply\nformat ascii 1.0\ncomment made elsewhere\ncomment origin_m 10 -20.5 1e3\n"
      "element camera 1\nproperty list uchar int ids\nproperty float f\n"
      "element vertex 1\nproperty float rot_3\nproperty float rot_2\nproperty float rot_1\n"
      "property float rot_0\nproperty uchar red\nproperty list uchar float more\n"
      "property double z\nproperty float y\nproperty float x\nproperty float opacity\n"
      "property float scale_2\nproperty float scale_1\nproperty float scale_0\n"
      "property float f_rest_8\nproperty float f_rest_0\nproperty float f_rest_1\n"
      "property float f_rest_2\nproperty float f_rest_3\nproperty float f_rest_4\n"
      "property float f_rest_5\nproperty float f_rest_6\nproperty float f_rest_7\n"
      "property float f_dc_2\nproperty float f_dc_1\nproperty float f_dc_0\nend_header\n"
      "2 5 6 0.5\n"
      "0.4 0.3 0.2 0.1 255 2 7 8 3 2 1 0.25 -3 -2 -1 8 0 1 2 3 4 5 6 7 0.75 0.5 0.125\n";
  write_file(scratch_file(), text);
  const SplatModel model = read_splat_ply(scratch_file()).model;
  EXPECT_EQ(model.origin_in_world_m, Eigen::Vector3d(10, -20.5, 1000));
  EXPECT_EQ(model.sh_degree, 1);
  ASSERT_EQ(model.splats.size(), 1u);
  const Splat& splat = model.splats[0];
  EXPECT_EQ(splat.centre_m, Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(splat.log_scale, Eigen::Vector3f(-1, -2, -3));
  EXPECT_EQ(splat.rotation_wxyz, Eigen::Vector4f(0.1f, 0.2f, 0.3f, 0.4f));
  EXPECT_EQ(splat.opacity_logit, 0.25f);
  EXPECT_EQ(splat.sh_dc, (std::array<float, 3>{0.125f, 0.5f, 0.75f}));
  // Three of each channel: red 0 1 2, green 3 4 5, blue 6 7 8.
  EXPECT_EQ(splat.sh_rest[2], 2);
  EXPECT_EQ(splat.sh_rest[15], 3);
  EXPECT_EQ(splat.sh_rest[32], 8);
  EXPECT_EQ(splat.sh_rest[3], 0);
}

TEST(SplatPly, RowsThatAreNoGaussianAreDroppedAndCounted) {
  const std::string rows =
      kRow + "nan 2 3 .1 .2 .3 4 -1 -2 -3 1 0 0 0\n" + "1 2 3 .1 .2 .3 inf -1 -2 -3 1 0 0 0\n" +
      "1 2 3 .1 .2 1e60 4 -1 -2 -3 1 0 0 0\n" + "1 2 3 .1 .2 .3 4 -1 -2 -3 0 0 0 0\n" + kRow;
  const std::string text = text_file(kDegreeZero, rows, 6);
  write_file(scratch_file(), text);
  const SplatFile file = read_splat_ply(scratch_file());
  EXPECT_EQ(file.model.splats.size(), 2u);
  EXPECT_EQ(file.not_finite, 3u);
  EXPECT_EQ(file.zero_rotations, 1u);
  const SplatPlyConfig strict{.invalid = SplatPlyConfig::Invalid::refuse};
  EXPECT_THAT(error_of(text, strict), HasSubstr("splat 1 has a value that is not finite"));
  const std::string zero = text_file(kDegreeZero, "1 2 3 .1 .2 .3 4 -1 -2 -3 0 0 0 0\n");
  EXPECT_THAT(error_of(zero, strict), HasSubstr("splat 0 has a rotation"));
  EXPECT_EQ(error_of(text_file(kDegreeZero, kRow), strict), "");
}

TEST(SplatPly, ErrorsNameWhatIsWrong) {
  EXPECT_THAT(error_of(text_file("x y z", "1 2 3\n")), HasSubstr("no property \"f_dc_0\""));
  EXPECT_THAT(error_of(text_file(kDegreeZero + " x", kRow)), HasSubstr("two properties \"x\""));
  EXPECT_THAT(error_of(text_file(kDegreeZero + " f_rest_0", kRow)),
              HasSubstr("1 of f_rest_; 0, 9, 24 or 45"));
  EXPECT_THAT(error_of(text_file(kDegreeZero + " f_rest_1", kRow)),
              HasSubstr("f_rest_1 but no f_rest_0"));
  EXPECT_THAT(error_of(text_file(kDegreeZero + " f_rest_45", kRow)), HasSubstr("f_rest_45"));
  EXPECT_THAT(error_of(text_file(kDegreeZero, kRow, 3)), HasSubstr("too short for 3"));
  EXPECT_THAT(error_of(text_file(kDegreeZero, kRow, 30'000'000)), HasSubstr("most_splats"));
  EXPECT_THAT(error_of(text_file(kDegreeZero, kRow, 2000)), HasSubstr("too short for 2000"));
  EXPECT_THAT(error_of(text_file(kDegreeZero, kRow + kRow, 2), {.most_splats = 1}),
              HasSubstr("there are 2 splats; most_splats is 1"));
  EXPECT_THAT(error_of("ply\nformat ascii 1.0\nend_header\n"), HasSubstr("no element \"vertex\""));
  EXPECT_THAT(error_of("solid"), HasSubstr("header"));
}

TEST(SplatPly, VariantsThatMeanSomethingElseAreRefusedByName) {
  std::string two = kDegreeZero;
  two.erase(two.find(" scale_2"), 8);
  EXPECT_THAT(error_of(text_file(two, "1 2 3 .1 .2 .3 4 -1 -2 1 0 0 0\n")),
              HasSubstr("2D Gaussians"));
  std::string one = two;
  one.erase(one.find(" scale_1"), 8);
  EXPECT_THAT(error_of(text_file(one, "1 2 3 .1 .2 .3 4 -1 1 0 0 0\n")), HasSubstr("one scale"));
  EXPECT_THAT(error_of(text_file("packed_position packed_rotation", "1 2\n")),
              HasSubstr("SuperSplat"));
  EXPECT_THAT(
      error_of(text_file(kDegreeZero + " filter_3D", "1 2 3 .1 .2 .3 4 -1 -2 -3 1 0 0 0 1\n")),
      HasSubstr("Mip-Splatting"));
  EXPECT_THAT(
      error_of(text_file(kDegreeZero + " motion_0", "1 2 3 .1 .2 .3 4 -1 -2 -3 1 0 0 0 1\n")),
      HasSubstr("move"));
  EXPECT_THAT(error_of(text_file("x y z red green blue", "1 2 3 1 1 1\n")), HasSubstr("f_dc_0"));
  EXPECT_EQ(error_of(text_file(kDegreeZero, kRow)), "");
}

TEST(SplatPly, AnOriginIsThreeFiniteNumbersOrAnError) {
  const auto with = [](const std::string& comment) {
    return error_of(text_file(kDegreeZero, kRow, 1, "comment " + comment + "\n"));
  };
  EXPECT_EQ(with("origin_m 1 2 3"), "");
  EXPECT_EQ(with("another origin_m 1"), "");
  EXPECT_EQ(with("origin_model lidar"), "");
  EXPECT_EQ(with("origin_m_of lidar"), "");
  for (const char* bad : {"origin_m 1 2", "origin_m 1 2 x", "origin_m 1 nan 3", "origin_m",
                          "origin_m 1 2 3 4", "origin_m1 2 3", "origin_m 1 2 1e999"}) {
    EXPECT_THAT(with(bad), HasSubstr("origin_m")) << bad;
  }
  EXPECT_THAT(with("origin_m 1 2 3\ncomment origin_m 1 2 3"), HasSubstr("two comments"));
}

TEST(SplatPly, ALowPassIsOneNumberInItsLimitsAndThatOfTheReferenceWhereThereIsNone) {
  const auto with = [](const std::string& comment) {
    return error_of(text_file(kDegreeZero, kRow, 1, comment));
  };
  EXPECT_EQ(with(""), "");
  EXPECT_EQ(read_splat_ply(scratch_file()).model.low_pass_px2, 0.3);
  EXPECT_EQ(with("comment low_pass_px2 0.05\n"), "");
  EXPECT_EQ(read_splat_ply(scratch_file()).model.low_pass_px2, 0.05);
  for (const char* bad : {"", " x", " nan", " 0", " -0.3", " 101", " 1e-7", " 0.1 0.1"})
    EXPECT_THAT(with("comment low_pass_px2" + std::string(bad) + "\n"), HasSubstr("low_pass_px2"))
        << bad;
}

TEST(SplatPly, AModelThatCouldNotBeReadIsNotWritten) {
  SplatModel blurred = random_model(1, 3);
  blurred.low_pass_px2 = 0;
  EXPECT_THROW(write_splat_ply(scratch_file(), blurred), std::invalid_argument);
  SplatModel model = random_model(1, 3);
  model.splats[2].log_scale.y() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(write_splat_ply(scratch_file(), model), std::invalid_argument);
  model = random_model(1, 3);
  model.splats[1].rotation_wxyz.setZero();
  EXPECT_THROW(write_splat_ply(scratch_file(), model), std::invalid_argument);
  model = random_model(1, 3);
  model.sh_degree = 4;
  EXPECT_THROW(write_splat_ply(scratch_file(), model), std::invalid_argument);
  EXPECT_FALSE(std::filesystem::exists(scratch_file()));
}

}  // namespace
}  // namespace cousin
