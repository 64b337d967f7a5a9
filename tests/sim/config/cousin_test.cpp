#include "sim/config/cousin.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace cousin {
namespace {

using ::testing::HasSubstr;

struct Thing {
  double size_m = 0.02, turn_rad = 0.5, green = 0.1;
  int leaves = 8;
  std::vector<double> albedo = {0.1, 0.2, 0.4};
  double left_noise = 2, right_noise = 3;
  std::string name = "thing";
};
Fields fields(Thing& t) {
  return {{"size_m", &t.size_m, "", 0, 0.03},
          {"turn_rad", &t.turn_rad, "", -7, 7},
          {"green", &t.green, "", 0, 1},
          {"leaves", &t.leaves, "", 0, 20},
          {"albedo", &t.albedo, "", 0, 1},
          {"rig.left.noise", &t.left_noise, "", 0, 100},
          {"rig.right.noise", &t.right_noise, "", 0, 100},
          {"name", &t.name, ""}};
}

constexpr const char* kTable = R"(
[growth]
"size_m" = { factor = 1.4 }
"green" = { to = 0.9 }
[light]
"turn_rad" = { step = 2.0 }
[texture]
"albedo" = { factor = 1.5 }
[sensor]
"rig.**.noise" = { factor = 2.0 }
[shape]
"leaves" = { to = 12.0 }
)";

std::vector<CousinMove> moves() { return read_cousin_moves(kTable, "table.toml"); }

Thing moved(const CousinDistance& distance, std::uint64_t seed) {
  Thing thing;
  move_to_cousin(fields(thing), moves(), distance, Rng(seed));
  return thing;
}

TEST(Cousin, ATwinIsTheReferenceToTheLastBit) {
  const Thing reference, twin = moved({}, 1);
  EXPECT_EQ(twin.size_m, reference.size_m);
  EXPECT_EQ(twin.albedo, reference.albedo);
  EXPECT_EQ(twin.left_noise, reference.left_noise);
  EXPECT_TRUE(is_twin({}));
  EXPECT_FALSE(is_twin({.light = 1e-9}));
}

TEST(Cousin, AnAxisMovesItsOwnKeysAndNoOther) {
  const Thing reference, thing = moved({.light = 1}, 3);
  EXPECT_NE(thing.turn_rad, reference.turn_rad);
  EXPECT_EQ(thing.size_m, reference.size_m);
  EXPECT_EQ(thing.green, reference.green);
  EXPECT_EQ(thing.left_noise, reference.left_noise);
  EXPECT_EQ(thing.leaves, reference.leaves);
}

TEST(Cousin, DrawsLieBetweenHalfAndAllOfTheRangeEitherWay) {
  int more = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const Thing thing = moved({.growth = 0.8, .light = 0.8}, seed);
    const double share = std::abs(std::log(thing.size_m / 0.02)) / std::log(1.4) / 0.8;
    EXPECT_GE(share, 0.5 - 1e-12);
    EXPECT_LE(share, 1 + 1e-12);
    EXPECT_GE(std::abs(thing.turn_rad - 0.5), 0.8 * 2.0 / 2 - 1e-12);
    EXPECT_LE(std::abs(thing.turn_rad - 0.5), 0.8 * 2.0 + 1e-12);
    EXPECT_DOUBLE_EQ(thing.green, 0.1 + 0.8 * (0.9 - 0.1));
    more += thing.turn_rad > 0.5;
  }
  EXPECT_NEAR(more, 100, 5 * 7.1);  // five standard deviations of a fair coin
}

TEST(Cousin, GrowingDistanceGoesOnAlongOneLine) {
  const double near = std::log(moved({.growth = 0.25}, 5).size_m / 0.02);
  const double far = std::log(moved({.growth = 1}, 5).size_m / 0.02);
  EXPECT_NEAR(far, 4 * near, 1e-12);
  // And what one axis draws does not depend on another.
  EXPECT_EQ(moved({.growth = 1, .light = 0.5}, 5).size_m, moved({.growth = 1}, 5).size_m);
}

TEST(Cousin, ListsAndPatternsMoveTogetherAndIntegersRound) {
  const Thing thing = moved({.shape = 0.6, .texture = 1, .sensor = 1}, 2);
  EXPECT_NEAR(thing.albedo[1] / thing.albedo[0], 2, 1e-12);
  EXPECT_NEAR(thing.albedo[2] / thing.albedo[0], 4, 1e-12);
  EXPECT_NEAR(thing.right_noise / thing.left_noise, 1.5, 1e-12);
  EXPECT_NE(thing.left_noise, 2);
  EXPECT_EQ(thing.leaves, 10);  // 8 + 0.6 * 4 = 10.4
}

TEST(Cousin, SaysWhatItMoved) {
  Thing thing;
  const auto changes = move_to_cousin(fields(thing), moves(), {.sensor = 1}, Rng(1));
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_EQ(changes[0].key, "rig.left.noise");
  EXPECT_EQ(changes[0].before, "2.0");
  EXPECT_THAT(comments_of(changes), HasSubstr("# cousin.sensor: rig.right.noise = 3.0 -> "));
  EXPECT_THAT(describe(moves()), HasSubstr("more or less by up to 2"));
}

template <class Call>
std::string refusal(Call call) {
  try {
    call();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Cousin, RefusesWhatLeavesLimitsOrIsNotThere) {
  Thing thing;
  thing.size_m = 0.025;  // times 1.4 is beyond 0.03
  const auto check = [&](const CousinDistance& d) {
    return refusal([&] { check_cousin(fields(thing), moves(), d); });
  };
  EXPECT_THAT(check({.growth = 1}), testing::AllOf(HasSubstr("cousin.growth = 1"),
                                                   HasSubstr("size_m"), HasSubstr("0.03")));
  EXPECT_EQ(check({.growth = 0.4}), "accepted");  // times 1.144
  EXPECT_EQ(check({.light = 1}), "accepted");
  const auto with = [&](const char* table, const CousinDistance& d) {
    return refusal([&] { check_cousin(fields(thing), read_cousin_moves(table, "table.toml"), d); });
  };
  EXPECT_THAT(with("[shape]\n\"height_m\" = { factor = 2.0 }\n", {.shape = 0.1}),
              HasSubstr("has no key height_m"));
  EXPECT_THAT(with("[sensor]\n\"rig.**.blur\" = { factor = 2.0 }\n", {.sensor = 0.1}),
              HasSubstr("moves nothing here along that axis"));
  EXPECT_THAT(with("[shape]\n\"name\" = { factor = 2.0 }\n", {.shape = 0.1}),
              HasSubstr("name is not a number"));
  EXPECT_THAT(with("[shape]\n\"leaves\" = { to = 2.0 }\n", {.light = 0.1}),
              HasSubstr("moves nothing here along that axis"));
}

TEST(Cousin, RefusesTablesByName) {
  const auto read = [](const char* table) {
    return refusal([&] { read_cousin_moves(table, "table.toml"); });
  };
  EXPECT_THAT(read("[colour]\n\"a\" = { factor = 2.0 }\n"), HasSubstr("[colour]"));
  EXPECT_THAT(read("[shape]\n\"a\" = 2.0\n"), HasSubstr("{ factor = X }"));
  EXPECT_THAT(read("[shape]\n\"a\" = { times = 2.0 }\n"), HasSubstr("\"times\""));
  EXPECT_THAT(read("[shape]\n\"a\" = { factor = -2.0 }\n"), HasSubstr("positive"));
  EXPECT_THAT(read("[shape]\n\"a\" = { factor = \"x\" }\n"), HasSubstr("number"));
}

}  // namespace
}  // namespace cousin
