#include "perception/splats/splat_start.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "perception/splats/near_points.h"
#include "sim/dataset/atomic_file.h"

namespace cousin {
namespace {

using ::testing::HasSubstr;

std::filesystem::path scratch_file(const std::string& ending) {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  return std::filesystem::path(::testing::TempDir()) / (std::string(test->name()) + ending);
}

std::string error_of(const std::string& ending, const std::string& bytes,
                     std::size_t most = kMostStartPoints) {
  write_file(scratch_file(ending), bytes);
  try {
    read_start_points(scratch_file(ending), most);
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr(scratch_file(ending).string()));
    return error.what();
  }
  return {};
}

std::vector<Eigen::Vector3d> random_positions(int count, double side) {
  std::vector<Eigen::Vector3d> positions;
  for (const StartPoint& p :
       random_start_points(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(side), count, Rng(1)))
    positions.push_back(p.position_m);
  return positions;
}

TEST(NearPoints, AgreesWithTryingAllPoints) {
  std::vector<Eigen::Vector3d> points = random_positions(400, 1);
  for (std::size_t i = 0; i < 60; ++i) points.push_back(points[0]);             // one place
  for (std::size_t i = 0; i < 60; ++i) points.push_back({0.01 * i, 0.5, 0.5});  // one line
  const NearPoints near(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::vector<double> all;
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (k != i) all.push_back((points[k] - points[i]).squaredNorm());
    }
    std::sort(all.begin(), all.end());
    all.resize(3);
    EXPECT_EQ(near.squared_distances_m2(i, 3), all) << i;
  }
}

TEST(NearPoints, FewPointsHaveFewNeighbours) {
  const std::vector<Eigen::Vector3d> two = {{0, 0, 0}, {3, 4, 0}};
  EXPECT_EQ(NearPoints(two).squared_distances_m2(0, 3), std::vector<double>{25});
  EXPECT_TRUE(NearPoints(std::span(two).first(1)).squared_distances_m2(0, 3).empty());
}

TEST(SplatStart, ALatticeHasItsSpacingAsScale) {
  std::vector<StartPoint> points;
  for (int i = 0; i < 125; ++i)
    points.push_back({0.25 * Eigen::Vector3d(i % 5, i / 5 % 5, i / 25), {255, 0, 51}});
  const SplatModel model = splats_from_points(points, {.sh_degree = 2, .opacity = 0.25});
  EXPECT_EQ(model.sh_degree, 2);
  EXPECT_EQ(model.origin_in_world_m, Eigen::Vector3d::Zero());
  ASSERT_EQ(model.splats.size(), 125u);
  for (std::size_t i = 0; i < 125; ++i) {
    const Splat& splat = model.splats[i];
    EXPECT_EQ(splat.centre_m, points[i].position_m.cast<float>());
    EXPECT_FLOAT_EQ(splat.log_scale.x(), std::log(0.25f));
    EXPECT_EQ(splat.log_scale.x(), splat.log_scale.z());
    EXPECT_FLOAT_EQ(splat.opacity_logit, std::log(1.0f / 3.0f));
    // 0.5 + dc Y gives the colour back.
    EXPECT_NEAR(0.5 + 0.28209479177387814 * splat.sh_dc[0], 1, 1e-6);
    EXPECT_NEAR(0.5 + 0.28209479177387814 * splat.sh_dc[1], 0, 1e-6);
    EXPECT_NEAR(0.5 + 0.28209479177387814 * splat.sh_dc[2], 0.2, 1e-6);
  }
}

TEST(SplatStart, APointWithANormalIsADiscAcrossIt) {
  std::vector<StartPoint> points;
  for (int i = 0; i < 25; ++i) points.push_back({0.1 * Eigen::Vector3d(i % 5, i / 5, 0)});
  const std::array<Eigen::Vector3d, 3> normals = {
      Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitZ(), Eigen::Vector3d(2, -1, 2) / 3};
  for (std::size_t i = 0; i < 3; ++i) points[i].normal = normals[i];
  const SplatModel model = splats_from_points(points, {.flatness = 0.2});
  for (std::size_t i = 0; i < 3; ++i) {
    const Splat& splat = model.splats[i];
    EXPECT_FLOAT_EQ(splat.log_scale.x(), splat.log_scale.y());
    EXPECT_NEAR(std::exp(splat.log_scale.z() - splat.log_scale.x()), 0.2, 1e-6);
    const Eigen::Quaternionf turn(splat.rotation_wxyz[0], splat.rotation_wxyz[1],
                                  splat.rotation_wxyz[2], splat.rotation_wxyz[3]);
    const Eigen::Vector3d axis = (turn * Eigen::Vector3f::UnitZ()).cast<double>();
    EXPECT_NEAR(std::abs(axis.dot(normals[i])), 1, 1e-6) << i;
  }
  EXPECT_EQ(model.splats[7].log_scale.x(), model.splats[7].log_scale.z());
  EXPECT_THROW(splats_from_points(points, {.flatness = 0}), std::invalid_argument);
}

TEST(SplatStart, APointSaysHowOpaqueItIs) {
  std::vector<StartPoint> points = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 2, 0}}};
  points[1].opacity = 0.75;
  const SplatModel model = splats_from_points(points, {.opacity = 0.5});
  EXPECT_FLOAT_EQ(model.splats[0].opacity_logit, 0);
  EXPECT_FLOAT_EQ(model.splats[1].opacity_logit, std::log(3.0F));
  for (const double wrong : {1.0, -0.1, std::nan("")}) {
    points[2].opacity = wrong;
    EXPECT_THROW(splats_from_points(points), std::invalid_argument) << wrong;
  }
}

TEST(SplatStart, ScaleIsTheRootMeanSquareOfThreeDistances) {
  const std::vector<StartPoint> points = {
      {{0, 0, 0}}, {{1, 0, 0}}, {{0, 2, 0}}, {{0, 0, 3}}, {{0, 0, 9}}};
  const SplatModel model = splats_from_points(points);
  EXPECT_FLOAT_EQ(model.splats[0].log_scale.x(), std::log(std::sqrt((1 + 4 + 9) / 3.0f)));
}

TEST(SplatStart, PointsInOnePlaceAndAloneHaveAScale) {
  std::vector<StartPoint> points;
  for (int i = 0; i < 100; ++i) points.push_back({{0.1 * i, 0, 0}});
  for (int i = 0; i < 10; ++i) points.push_back({{50, 0, 0}});
  const SplatModel model = splats_from_points(points);
  // Inside the row: 0.1, 0.1 and 0.2 away; the crowd has a hundredth of that.
  const float row = std::log(0.1f * std::sqrt(2.0f));
  EXPECT_FLOAT_EQ(model.splats[50].log_scale.x(), row);
  EXPECT_FLOAT_EQ(model.splats[105].log_scale.x(), row + std::log(0.01f));
  const std::vector<StartPoint> one = {{{1, 2, 3}}};
  EXPECT_FLOAT_EQ(splats_from_points(one, {.alone_m = 0.5}).splats[0].log_scale.y(),
                  std::log(0.5f));
  EXPECT_TRUE(splats_from_points({}).splats.empty());
}

TEST(SplatStart, PointsFarFromTheOriginKeepTheirPlacesAndScales) {
  std::vector<StartPoint> here, far;
  const Eigen::Vector3d offset(4.3e6, -5e5, 1e3);
  for (const Eigen::Vector3d& p : random_positions(200, 0.1)) {
    here.push_back({p});
    far.push_back({p + offset});
  }
  const SplatModel a = splats_from_points(here);
  const SplatModel b = splats_from_points(far);
  for (std::size_t i = 0; i < here.size(); ++i) {
    const Eigen::Vector3d place = b.origin_in_world_m + b.splats[i].centre_m.cast<double>();
    // Doubles resolve 9e-10 m at 4.3e6 m, floats 6e-9 at 0.1 m.
    EXPECT_LT((place - far[i].position_m).norm(), 2e-8);
    EXPECT_NEAR(a.splats[i].log_scale.x(), b.splats[i].log_scale.x(), 1e-5);
  }
}

TEST(SplatStart, OnePointFarOffMovesNoOther) {
  std::vector<StartPoint> points;
  for (const Eigen::Vector3d& p : random_positions(200, 0.1)) points.push_back({p});
  const SplatModel alone = splats_from_points(points);
  points.push_back({{1e300, 0, -1e300}});
  const SplatModel with = splats_from_points(points);
  EXPECT_EQ(with.origin_in_world_m, alone.origin_in_world_m);
  for (std::size_t i = 0; i < 200; ++i)
    EXPECT_EQ(with.splats[i].centre_m, alone.splats[i].centre_m);
}

TEST(SplatStart, RandomPointsFillTheirBox) {
  const auto points = random_start_points({-1, 2, 5}, {1, 3, 9}, 3000, Rng(5));
  ASSERT_EQ(points.size(), 3000u);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const StartPoint& p : points) {
    EXPECT_TRUE((p.position_m.array() >= Eigen::Array3d(-1, 2, 5)).all());
    EXPECT_TRUE((p.position_m.array() < Eigen::Array3d(1, 3, 9)).all());
    mean += p.position_m / 3000.0;
  }
  // A uniform side has sigma 0.289 of itself, its mean over 3000 a 55th of that; allow five.
  EXPECT_LT((mean - Eigen::Vector3d(0, 2.5, 7)).cwiseQuotient(Eigen::Vector3d(2, 1, 4)).norm(),
            5 * std::sqrt(3.0) * 0.289 / 54.8);
  EXPECT_THROW(random_start_points({0, 0, 0}, {1, 0, 1}, 5, Rng(5)), std::invalid_argument);
  EXPECT_THROW(random_start_points({0, 0, 0}, {1, 1, 1}, -1, Rng(5)), std::invalid_argument);
}

TEST(SplatStart, ColmapsPointsAreReadFromTextAndBytes) {
  const std::string text = "# Points\n7 1.5 -2 3.25 255 128 0 0.5 1 2 3 4\n\n9 0 0 1e-3 1 2 3 -1\n";
  std::string bytes;
  const auto put = [&](auto value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes.append(raw, sizeof value);
  };
  put(std::uint64_t{2});
  put(std::uint64_t{7});
  for (const double v : {1.5, -2.0, 3.25}) put(v);
  for (const int c : {255, 128, 0}) put(static_cast<std::uint8_t>(c));
  put(0.5);
  put(std::uint64_t{2});
  for (int i = 0; i < 4; ++i) put(std::int32_t{i});
  put(std::uint64_t{9});
  for (const double v : {0.0, 0.0, 1e-3}) put(v);
  for (const int c : {1, 2, 3}) put(static_cast<std::uint8_t>(c));
  put(-1.0);
  put(std::uint64_t{0});
  write_file(scratch_file(".txt"), text);
  write_file(scratch_file(".bin"), bytes);
  for (const char* ending : {".txt", ".bin"}) {
    const StartPoints read = read_start_points(scratch_file(ending));
    ASSERT_EQ(read.points.size(), 2u) << ending;
    EXPECT_EQ(read.points[0].position_m, Eigen::Vector3d(1.5, -2, 3.25));
    EXPECT_EQ(read.points[0].color, (Rgb8{255, 128, 0}));
    EXPECT_EQ(read.points[1].position_m, Eigen::Vector3d(0, 0, 1e-3));
  }
  EXPECT_THAT(error_of(".bin", bytes.substr(0, bytes.size() - 1)), HasSubstr("byte"));
  EXPECT_THAT(error_of(".bin", bytes.substr(0, 60)), HasSubstr("too short"));
  EXPECT_THAT(error_of(".bin", ""), HasSubstr("ends before the count"));
  EXPECT_THAT(error_of(".txt", "7 1 2 nan 1 2 3 0\n"), HasSubstr("line 1"));
  EXPECT_THAT(error_of(".txt", "7 1 2 3 1 2 300 0\n"), HasSubstr("300"));
  EXPECT_THAT(error_of(".txt", "7 1 2 3 1 2 3 0 5\n"), HasSubstr("no pair"));
}

TEST(SplatStart, PointsOfAPlyAreReadWithTheirColours) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n"
      "property double z\n";
  const std::string bytes = header +
                            "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                            "end_header\n1 2 3 255 0 7\nnan 2 3 1 1 1\n4 5 6 1 2 3\n";
  write_file(scratch_file(".ply"), bytes);
  StartPoints read = read_start_points(scratch_file(".ply"));
  EXPECT_EQ(read.not_finite, 1u);
  ASSERT_EQ(read.points.size(), 2u);
  EXPECT_EQ(read.points[0].color, (Rgb8{255, 0, 7}));
  EXPECT_EQ(read.points[1].position_m, Eigen::Vector3d(4, 5, 6));
  write_file(scratch_file(".ply"),
             header +
                 "property float red\nproperty float green\nproperty float blue\n"
                 "end_header\n1 2 3 1 0 .2\n1 2 3 1 1 1\n4 5 6 1 0 0\n");
  EXPECT_EQ(read_start_points(scratch_file(".ply")).points[0].color, (Rgb8{255, 0, 51}));
  write_file(scratch_file(".ply"), header + "end_header\n1 2 3\n1 2 3\n1 2 3\n");
  EXPECT_EQ(read_start_points(scratch_file(".ply")).points[0].color, (Rgb8{128, 128, 128}));
  EXPECT_THAT(error_of(".ply", bytes, 2), HasSubstr("there are 3 points; the limit is 2"));
  EXPECT_THAT(error_of(".ply", header + "property int red\nproperty int green\nproperty int "
                                        "blue\nend_header\n1 2 3 256 0 0\n1 2 3 0 0 0\n1 2 3 0 0 "
                                        "0\n"),
              HasSubstr("vertex 0: red = 256"));
  EXPECT_THAT(error_of(".pcd", ""), HasSubstr(".ply, points3D.txt"));
}

TEST(SplatStart, RefusesPointsAndConfigurationsThatAreNone) {
  const std::vector<StartPoint> bad = {{{0, std::nan(""), 0}}};
  EXPECT_THROW(splats_from_points(bad), std::invalid_argument);
  EXPECT_THROW(splats_from_points({}, {.opacity = 1}), std::invalid_argument);
  EXPECT_THROW(splats_from_points({}, {.sh_degree = 4}), std::invalid_argument);
  EXPECT_THROW(splats_from_points({}, {.alone_m = 0}), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
