#include "sim/config/fields.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/config/nearest_word.h"

namespace cousin {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

enum class Colour { red, green };

struct Inner {
  int planes = 64;
  double smoothness = 0.1;
};

struct Outer {
  double length_m = 0.008;
  std::uint64_t seed = 1;
  bool fast = false;
  std::string name = "seed";
  std::vector<double> spread = {0.1, 0.2};
  Colour colour = Colour::red;
  Inner mvs;
};

Fields fields(Inner& config) {
  return {{"planes", &config.planes, "depth planes", 2, 1024},
          {"smoothness", &config.smoothness, "weight", 0, 10}};
}

Fields fields(Outer& config) {
  const TextField colour{
      [&config] { return std::string(config.colour == Colour::red ? "red" : "green"); },
      [&config](const std::string& text) {
        if (text != "red" && text != "green") throw std::invalid_argument("must be red or green");
        config.colour = text == "red" ? Colour::red : Colour::green;
      }};
  return Fields{{"length_m", &config.length_m, "longest side", 1e-3, 1},
                {"seed", &config.seed, "of all random streams"},
                {"fast", &config.fast, "leave out the second pass"},
                {"name", &config.name, "of the run"},
                {"spread", &config.spread, "relative, one an axis", 0, 1},
                {"colour", colour, "of the coat"}} +
         nested("mvs", fields(config.mvs));
}

/// What reading `text` as "a.toml" throws; empty if nothing.
std::string error_of(const std::string& text, MissingKeys missing = MissingKeys::keep_default) {
  Outer config;
  try {
    read_toml_text(text, "a.toml", fields(config), missing);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

std::string set_error_of(const std::string& assignment) {
  Outer config;
  try {
    set_field(fields(config), assignment);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Fields, TomlRoundTripIsExact) {
  Outer config{
      .length_m = 0.1 + 0.2 / 3,
      .seed = std::numeric_limits<std::uint64_t>::max(),  // above what a TOML integer can hold
      .fast = true,
      .name = "a \"quoted\" \\ name\nand a second line",
      .spread = {1e-300, 1, 1.0 / 3},
      .colour = Colour::green,
      .mvs = {.planes = 7, .smoothness = 5e-324}};
  const std::string text = to_toml(fields(config));
  Outer back;
  read_toml_text(text, "round trip", fields(back), MissingKeys::error);
  EXPECT_EQ(back.length_m, config.length_m);
  EXPECT_EQ(back.seed, config.seed);
  EXPECT_EQ(back.fast, config.fast);
  EXPECT_EQ(back.name, config.name);
  EXPECT_EQ(back.spread, config.spread);
  EXPECT_EQ(back.colour, config.colour);
  EXPECT_EQ(back.mvs.planes, config.mvs.planes);
  EXPECT_EQ(back.mvs.smoothness, config.mvs.smoothness);
  EXPECT_EQ(to_toml(fields(back)), text);
}

TEST(Fields, PlainKeysPrecedeTablesWhateverTheirOrder) {
  Inner a, b;
  double top = 2;
  const Fields all = nested("a", fields(a)) + Fields{{"top", &top, ""}} + nested("a.b", fields(b));
  EXPECT_EQ(
      to_toml(all),
      "top = 2.0\n\n[a]\nplanes = 64\nsmoothness = 0.1\n\n[a.b]\nplanes = 64\nsmoothness = 0.1\n");
}

TEST(Fields, TablesAndDottedKeysAreTheSame) {
  Outer config;
  read_toml_text("mvs.planes = 5", "a.toml", fields(config), MissingKeys::keep_default);
  EXPECT_EQ(config.mvs.planes, 5);
  read_toml_text("[mvs]\nplanes = 6", "a.toml", fields(config), MissingKeys::keep_default);
  EXPECT_EQ(config.mvs.planes, 6);
  EXPECT_EQ(config.mvs.smoothness, 0.1);  // a missing key keeps its default
}

TEST(Fields, AnIntegerIsANumber) {
  Outer config;
  read_toml_text("length_m = 1", "a.toml", fields(config), MissingKeys::keep_default);
  EXPECT_EQ(config.length_m, 1.0);
  EXPECT_THAT(error_of("[mvs]\nplanes = 5.0"),
              HasSubstr("a.toml:2: mvs.planes = 5: must be an integer"));
}

TEST(Fields, ErrorsNameFileLineKeyValueAndLimit) {
  EXPECT_THAT(error_of("\nlength_m = 2.5"),
              HasSubstr("a.toml:2: length_m = 2.5: must be in [0.001, 1]"));
  EXPECT_THAT(error_of("length_m = nan"), HasSubstr("length_m = nan: must be in"));
  EXPECT_THAT(error_of("length_m = inf"), HasSubstr("length_m = inf: must be in"));
  EXPECT_THAT(error_of("length_m = \"long\""),
              HasSubstr("a.toml:1: length_m = \"long\": must be a number"));
  EXPECT_THAT(error_of("fast = 1"), HasSubstr("fast = 1: must be true or false"));
  EXPECT_THAT(error_of("name = 1"), HasSubstr("name = 1: must be text"));
  EXPECT_THAT(error_of("seed = -1"), HasSubstr("seed = -1: must be zero or a positive integer"));
  EXPECT_THAT(error_of("spread = [0.1, 1.5]"),
              HasSubstr("spread = [0.1, 1.5]: must be numbers that are in [0, 1]"));
  EXPECT_THAT(error_of("spread = [0.1, \"x\"]"), HasSubstr("spread: must be a list of numbers"));
  EXPECT_THAT(error_of("colour = \"blue\""),
              HasSubstr("a.toml:1: colour = \"blue\": must be red or green"));
  EXPECT_THAT(error_of("name = 1979-05-27"), HasSubstr("a.toml:1: name: dates and times"));
  EXPECT_THAT(error_of("mvs = 3"), HasSubstr("a.toml:1: unknown key 'mvs'"));
  EXPECT_THAT(error_of("[length_m]\nx = 1"), HasSubstr("length_m"));
  EXPECT_THAT(error_of("[mvs]\nplanes = 99999999999"), HasSubstr("must be in [2, 1024]"));
}

TEST(Fields, AnUnknownKeyNamesTheNearest) {
  EXPECT_THAT(error_of("fast = true\nlenght_m = 1"),
              AllOf(HasSubstr("a.toml:2: unknown key 'lenght_m'"), HasSubstr("'length_m'")));
  EXPECT_THAT(error_of("[mvs]\nplane = 1"),
              AllOf(HasSubstr("a.toml:2: unknown key 'mvs.plane'"), HasSubstr("'mvs.planes'")));
  EXPECT_THAT(set_error_of("planes=3"), HasSubstr("nearest key is 'mvs.planes'"));
  EXPECT_THAT(set_error_of("msv.planes=3"), HasSubstr("nearest key is 'mvs.planes'"));
  EXPECT_THAT(set_error_of("fsat=true"), HasSubstr("nearest key is 'fast'"));
}

TEST(Fields, AnUnknownKeyNamesNoneThatNobodyCouldHaveMeant) {
  EXPECT_THAT(set_error_of("pipeline.method=ours"),
              testing::EndsWith("unknown key 'pipeline.method'; there is no section 'pipeline'"));
  EXPECT_THAT(set_error_of("scene.colour=red"),
              HasSubstr("there is no section 'scene'; 'colour' stands alone"));
  EXPECT_THAT(set_error_of("mvs.colour=red"), HasSubstr("there are mvs.planes, mvs.smoothness"));
  EXPECT_THAT(set_error_of("temperature=3"), HasSubstr("no key has a name like it"));
  for (const char* far : {"day=1", "x=1", "mvs.x=1", "distance=1", "=1"})
    EXPECT_THAT(set_error_of(far), testing::Not(HasSubstr("nearest"))) << far;
}

TEST(Fields, ADecimalCommaIsNamed) {
  EXPECT_THAT(set_error_of("length_m=0,5"),
              HasSubstr("length_m = \"0,5\": must be a number; decimals take a point: 0.5"));
}

TEST(NearestWord, NeighboursThatChangePlacesAreOneEdit) {
  EXPECT_EQ(edit_distance("sedes", "seeds"), 1U);
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
  EXPECT_TRUE(may_mean("rnu", "run"));
  EXPECT_FALSE(may_mean("method", "bend"));
  EXPECT_FALSE(may_mean("x", "z"));
}

TEST(Fields, MissingKeysAreNamedWhereAllAreNeeded) {
  EXPECT_THAT(
      error_of("length_m = 0.1\nseed = 1\nfast = true\nname = \"n\"\nspread = []\ncolour = \"red\"",
               MissingKeys::error),
      HasSubstr("a.toml: missing keys: mvs.planes, mvs.smoothness"));
}

TEST(Fields, BrokenTextIsAnErrorWithALine) {
  EXPECT_THAT(error_of("fast = true\nlength_m = = 1"), HasSubstr("a.toml:2"));
  EXPECT_THAT(error_of("length_m = 0.1\nlength_m = 0.2"), HasSubstr("a.toml"));
  EXPECT_THAT(error_of("name = \"open"), HasSubstr("a.toml:1"));
  EXPECT_NE(error_of(std::string("\0\x01\xff", 3)), "");
}

TEST(Fields, HostileNestingIsAnErrorNotAStackOverflow) {
  EXPECT_THAT(error_of("spread = " + std::string(4000, '[')), HasSubstr("opening brackets"));
  EXPECT_THAT(error_of("name = \"" + std::string(5000, 'x') + "\""),
              HasSubstr("a.toml:1: 5009 characters"));
  EXPECT_THAT(error_of(std::string(2 << 20, '\n')), HasSubstr("bytes; the limit is"));
  std::string dotted = "a";
  for (int i = 0; i < 2000; ++i) dotted += ".a";
  EXPECT_THAT(error_of(dotted + " = 1"), HasSubstr("unknown key"));
}

TEST(Fields, SetTakesTextWithoutQuotes) {
  Outer config;
  const Fields all = fields(config);
  set_field(all, "length_m=1e-2");
  set_field(all, "seed=18446744073709551615");
  set_field(all, "fast=true");
  set_field(all, "name=maize = yellow");
  set_field(all, "spread=0.5,0.25");
  set_field(all, "colour=green");
  set_field(all, "mvs.planes = 12");
  EXPECT_EQ(config.length_m, 0.01);
  EXPECT_EQ(config.seed, std::numeric_limits<std::uint64_t>::max());
  EXPECT_TRUE(config.fast);
  EXPECT_EQ(config.name, "maize = yellow");
  EXPECT_EQ(config.spread, (std::vector<double>{0.5, 0.25}));
  EXPECT_EQ(config.colour, Colour::green);
  EXPECT_EQ(config.mvs.planes, 12);
  set_field(all, "name=\"12\"");
  EXPECT_EQ(config.name, "12");
  set_field(all, "spread=[]");
  EXPECT_TRUE(config.spread.empty());
}

TEST(Fields, SetErrorsNameKeyValueAndLimit) {
  EXPECT_THAT(set_error_of("length_m"), HasSubstr("'length_m': must be key=value"));
  EXPECT_THAT(set_error_of("length_m=7"), HasSubstr("length_m = 7: must be in [0.001, 1]"));
  EXPECT_THAT(set_error_of("length_m=7mm"), HasSubstr("length_m = \"7mm\": must be a number"));
  EXPECT_THAT(set_error_of("fast=yes"), HasSubstr("fast = \"yes\": must be true or false"));
  EXPECT_THAT(set_error_of("seed=-1"),
              HasSubstr("seed = \"-1\": must be zero or a positive integer"));
  EXPECT_THAT(set_error_of("spread=0.1,,0.2"), HasSubstr("must be a list of numbers"));
  EXPECT_THAT(set_error_of("mvs.planes=2.5"), HasSubstr("mvs.planes = 2.5: must be an integer"));
}

TEST(Fields, DescribeShowsKeyDefaultLimitsAndHelp) {
  Inner config;
  EXPECT_EQ(describe(fields(config)),
            "planes      64   [2, 1024]  depth planes\nsmoothness  0.1  [0, 10]    weight\n");
}

TEST(Fields, FilesAreReadAndMissingOnesNamed) {
  const std::filesystem::path folder = ::testing::TempDir();
  const auto file = folder / "cousin_fields_test.toml";
  std::ofstream(file) << "length_m = 0.5\n";
  Outer config;
  read_toml(file, fields(config), MissingKeys::keep_default);
  EXPECT_EQ(config.length_m, 0.5);
  std::filesystem::remove(file);
  for (const auto& bad : {file, folder}) {
    try {
      read_toml(bad, fields(config), MissingKeys::keep_default);
      FAIL() << "read " << bad;
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr(bad.string()));
    }
  }
}

TEST(Fields, AnOptionalKeyMayBeMissingWhereOthersMustNot) {
  Inner config;
  Fields rows = fields(config);
  EXPECT_THROW(read_toml_text("planes = 3", "t", rows, MissingKeys::error), std::runtime_error);
  rows[1].optional = true;
  read_toml_text("planes = 3", "t", rows, MissingKeys::error);
  EXPECT_EQ(config.planes, 3);
  EXPECT_EQ(config.smoothness, 0.1);
}

TEST(Toml, TablesAreNamedInTheOrderOfTheFile) {
  EXPECT_THAT(toml_tables("a = 1\n[right]\nx = 1\n[left]\n[left.inner]\n", "t"),
              ::testing::ElementsAre("right", "left"));
  EXPECT_THAT(toml_tables("", "t"), ::testing::IsEmpty());
  EXPECT_THROW(toml_tables("[left\n", "t"), std::runtime_error);
}

}  // namespace
}  // namespace cousin
