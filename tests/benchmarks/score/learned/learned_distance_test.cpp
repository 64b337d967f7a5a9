#include "benchmarks/score/learned/learned_distance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <torch/script.h>

#include <fstream>
#include <stdexcept>

namespace cousin {
namespace {

namespace fs = std::filesystem;

/// A network of one line, saved as a user would save LPIPS.
fs::path network_of(const std::string& name, const std::string& body) {
  torch::jit::Module network(name);
  network.define("def forward(self, image, photograph):\n    return " + body + "\n");
  fs::path file = fs::path(testing::TempDir()) / (name + ".pt");
  network.save(file.string());
  return file;
}

FidelityPlanes planes(int width, int height, float red, float green, float blue) {
  return {Image<float>(width, height, red), Image<float>(width, height, green),
          Image<float>(width, height, blue)};
}

std::string error_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

TEST(LearnedDistance, ANetworkSeesBothImagesFromMinusOneToOne) {
  const auto square = load_learned_distance(
      network_of("square", "((image - photograph) ** 2).mean()"), COUSIN_TORCH_MODULE);
  const FidelityPlanes black = planes(20, 10, 0, 0, 0);
  EXPECT_EQ(square->between(black, black), 0);
  // One channel of three, the whole of its range: 2 squared over 3. Beyond it values are clamped.
  EXPECT_NEAR(square->between(planes(20, 10, 1, 0, 0), black), 4.0 / 3, 1e-6);
  EXPECT_NEAR(square->between(planes(20, 10, 7, -3, 0), black), 4.0 / 3, 1e-6);
  // Channels come in order, and rows are rows: the mean of blue's lower half alone.
  const auto corner = load_learned_distance(
      network_of("corner", "image[0, 2, 5:, :].mean() - photograph[0, 0, 0, 0]"),
      COUSIN_TORCH_MODULE);
  FidelityPlanes lower = black;
  for (int y = 5; y < 10; ++y) {
    for (int x = 0; x < 20; ++x) lower[2](x, y) = 1;
  }
  EXPECT_NEAR(corner->between(lower, black), 2, 1e-6);
}

TEST(LearnedDistance, WhatIsNoDistanceIsNamed) {
  const FidelityPlanes grey = planes(8, 8, 0.5F, 0.5F, 0.5F);
  const auto map =
      load_learned_distance(network_of("map", "image - photograph"), COUSIN_TORCH_MODULE);
  EXPECT_THAT(error_of([&] { map->between(grey, grey); }),
              testing::AllOf(testing::HasSubstr("map.pt"), testing::HasSubstr("192 numbers")));
  const auto nan = load_learned_distance(network_of("nan", "(image - photograph).mean() / 0.0"),
                                         COUSIN_TORCH_MODULE);
  EXPECT_THAT(error_of([&] { nan->between(grey, grey); }), testing::HasSubstr("no finite number"));
  EXPECT_THROW(map->between(grey, planes(8, 7, 0, 0, 0)), std::invalid_argument);
}

TEST(LearnedDistance, FilesThatAreNoNetworkAreNamed) {
  const fs::path file = fs::path(testing::TempDir()) / "text.pt";
  std::ofstream(file) << "no network";
  EXPECT_THAT(error_of([&] { load_learned_distance(file, COUSIN_TORCH_MODULE); }),
              testing::AllOf(testing::HasSubstr("text.pt"), testing::HasSubstr("TorchScript")));
  EXPECT_THAT(error_of([&] { load_learned_distance("/nowhere.pt", COUSIN_TORCH_MODULE); }),
              testing::HasSubstr("/nowhere.pt: is no file"));
  EXPECT_THAT(error_of([&] { load_learned_distance(file, "/nowhere.so"); }),
              testing::HasSubstr("scripts/build torch"));
}

}  // namespace
}  // namespace cousin
