#include "scenes/seeds/cultivar.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <stdexcept>

namespace cousin {
namespace {

struct Sample {
  Eigen::Vector3d mean_m, sigma_m;
  double correlation = 0;  ///< of length and width
};

Sample draw_many(const CultivarConfig& config, SizeSpread spread, int count) {
  Rng rng(11);
  std::vector<Eigen::Vector3d> sizes;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < count; ++i) {
    sizes.push_back(draw_size_m(config, spread, rng));
    sum += sizes.back();
  }
  Sample sample;
  sample.mean_m = sum / count;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& s : sizes)
    covariance += (s - sample.mean_m) * (s - sample.mean_m).transpose();
  covariance /= count - 1;
  sample.sigma_m = covariance.diagonal().cwiseSqrt();
  sample.correlation = covariance(0, 1) / (sample.sigma_m[0] * sample.sigma_m[1]);
  return sample;
}

TEST(Cultivar, SizesHaveTheStatedMeansAndSpreads) {
  constexpr int kCount = 4000;
  for (const std::string& name : cultivar_names()) {
    const CultivarConfig& config = cultivar(name);
    const Sample sample = draw_many(config, SizeSpread::literature, kCount);
    const Eigen::Vector3d sigma_m = size_sigma_m(config, SizeSpread::literature);
    const Eigen::Vector3d mean_m(config.length_m, config.width_m, config.height_m);
    for (int i = 0; i < 3; ++i) {
      // Five standard errors of the mean; the spread within five of its own (0.9 % each for a cut
      // normal) plus 3 % for what the joint cut of three correlated axes takes off.
      EXPECT_NEAR(sample.mean_m[i], mean_m[i],
                  5 * sigma_m[i] / std::sqrt(kCount) + 0.002 * mean_m[i])
          << name;
      EXPECT_NEAR(sample.sigma_m[i], sigma_m[i], (5 * 0.009 + 0.03) * sigma_m[i])
          << name << " axis " << i;
    }
    EXPECT_NEAR(sample.correlation, config.size_share, 0.12) << name;
  }
}

TEST(Cultivar, PaperSpreadIsWhatRmseAndR2Imply) {
  // Zhengdan 958: 0.304 / sqrt(1 - 0.9361) = 1.203 mm.
  EXPECT_NEAR(size_sigma_m(cultivar("zhengdan958"), SizeSpread::paper)[0], 1.203e-3, 1e-6);
  for (const std::string& name : cultivar_names()) {
    const CultivarConfig& config = cultivar(name);
    const Eigen::Vector3d wanted_m = size_sigma_m(config, SizeSpread::paper);
    const Sample sample = draw_many(config, SizeSpread::paper, 2000);
    for (int i = 0; i < 3; ++i) {
      // Draws that would swap the order of the axes are redrawn, which narrows the spread by up to
      // a fifth.
      EXPECT_GT(sample.sigma_m[i], 0.75 * wanted_m[i]) << name << " axis " << i;
      EXPECT_LT(sample.sigma_m[i], 1.08 * wanted_m[i]) << name << " axis " << i;
    }
  }
}

TEST(Cultivar, NamesAreSixAndUnique) {
  const std::vector<std::string> names = cultivar_names();
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), 6U);
}

TEST(Cultivar, AnUnknownNameListsThoseThatExist) {
  try {
    cultivar("golden_bantam");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("golden_bantam"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("jimai22"), std::string::npos);
  }
}

}  // namespace
}  // namespace cousin
