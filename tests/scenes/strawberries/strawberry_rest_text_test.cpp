#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/scenes/strawberries/small_stretch.h"

namespace cousin {
namespace {

const StrawberriesSceneConfig& stretch() {
  static const StrawberriesSceneConfig config = small_stretch(3);
  return config;
}

StandRest read(const std::string& text) {
  return rest_from_text(text, "some.stand", stretch().stand, stretch().bed, Rng(1));
}

/// A rest whose numbers are not round.
StandRest crooked() {
  StandRest rest = weightless(stretch(), Rng(1));
  Rng rng(2);
  rest.sag.time_s = 1.0 / 3;
  for (auto& sections : rest.sag.bent.sections) {
    for (Pose& pose : sections) {
      pose.rotation = Eigen::Quaterniond(normal(rng), normal(rng), normal(rng), normal(rng));
      pose.rotation.normalize();
      pose.translation_m = {uniform(rng) / 3, -uniform(rng) * 1e-17, uniform(rng)};
    }
  }
  for (auto& angles : rest.sag.bent.joints_rad) {
    for (double& angle : angles) angle = normal(rng);
  }
  return rest;
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  if (at == std::string::npos) throw std::logic_error("no \"" + what + "\"");
  return text.replace(at, what.size(), by);
}

TEST(StrawberryRestText, ReadsBackBitByBit) {
  const StandRest rest = crooked();
  const std::string text = to_text(rest);
  const StandRest back = read(text);
  EXPECT_EQ(to_text(back), text);
  ASSERT_EQ(back.sag.bent.sections.size(), rest.sag.bent.sections.size());
  for (std::size_t s = 0; s < rest.sag.bent.sections.size(); ++s) {
    for (std::size_t n = 0; n < rest.sag.bent.sections[s].size(); ++n) {
      const Pose &a = rest.sag.bent.sections[s][n], &b = back.sag.bent.sections[s][n];
      EXPECT_EQ(a.rotation.coeffs(), b.rotation.coeffs());
      EXPECT_EQ(a.translation_m, b.translation_m);
    }
  }
  EXPECT_EQ(back.sag.bent.joints_rad, rest.sag.bent.joints_rad);
}

TEST(StrawberryRestText, HostileTextIsRefusedNamingTheFile) {
  const std::string text = to_text(crooked());
  const std::string stems = "stems " + std::to_string(crooked().sag.bent.sections.size());
  const std::vector<std::string> bad = {
      "",
      "cousin",
      replaced(text, "attempt 0", "attempt -1"),
      replaced(text, "attempt 0", "attempt 0.5"),
      replaced(text, "sag 0.33", "sag nan"),
      replaced(text, "sag 0.33", "sag 1e999"),
      replaced(text, "sag 0.33", "sag -0.33"),
      replaced(text, "sag 0.33", "sag 0x33"),
      replaced(text, stems, "stems 4294967297"),
      replaced(text, stems, "stems 1"),
      replaced(text, "stem 15", "stem 400"),
      replaced(text, "end\n", "end\nmore"),
      text.substr(0, text.size() / 2),
      text.substr(0, text.size() - 5),
  };
  for (const std::string& one : bad) {
    try {
      read(one);
      ADD_FAILURE() << one.substr(0, 120);
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(std::string(error.what()).find("some.stand: "), 0U) << error.what();
    }
  }
}

TEST(StrawberryRestText, RotationsMustBeOfUnitNorm) {
  StandRest rest = crooked();
  rest.sag.bent.sections[0][1].rotation.coeffs() *= 0.9;
  EXPECT_THROW(read(to_text(rest)), std::runtime_error);
}

TEST(StrawberryRestText, ARestOfAnotherStandIsRefused) {
  const std::string text = to_text(weightless(small_stretch(4), Rng(9)));
  EXPECT_THROW(read(text), std::runtime_error);
}

}  // namespace
}  // namespace cousin
