// The folder that a user hands over: what is read, and what is said of mistakes in it.
#include "benchmarks/tools/fit_sensor/recordings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "benchmarks/tools/fit_sensor/preset_patch.h"
#include "benchmarks/tools/fit_sensor/sensor_fit.h"
#include "sim/dataset/atomic_file.h"
#include "sim/imaging/image_io.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// What a call says when it throws; "" if it does not.
template <class Call>
std::string error_of(const Call& call) {
  try {
    call();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

Recordings index(const std::vector<std::string>& folders, const std::string& toml = "") {
  return recordings_from_index(folders, toml, "recordings.toml");
}

TEST(Recordings, NamesOfFoldersSayTheDistances) {
  const Recordings r =
      index({"wall_1.20m", "wall_60cm_dim", "wall_850mm", "dark", "flat_b", "flat_a"});
  ASSERT_EQ(r.walls.size(), 3U);
  EXPECT_DOUBLE_EQ(r.walls[0].distance_m, 0.6);
  EXPECT_DOUBLE_EQ(r.walls[1].distance_m, 0.85);
  EXPECT_DOUBLE_EQ(r.walls[2].distance_m, 1.2);
  ASSERT_EQ(r.flats.size(), 2U);
  EXPECT_EQ(r.flats[0].name, "flat_a");
}

TEST(Recordings, TheIndexOverridesNamesAndDefaults) {
  const Recordings r = index({"wall_a", "wall_0.60m"},
                             "depth_unit_m = 0.0001\nlight = 0.5\nregion_px = [10, 20, 300, 200]\n"
                             "[wall_a]\ndistance_m = 0.4\nlight = 1\n"
                             "[\"wall_0.60m\"]\ndistance_m = 0.612\ndistance_sigma_m = 0.0005\n");
  EXPECT_DOUBLE_EQ(r.depth_unit_m.value(), 0.0001);
  EXPECT_FALSE(r.focal_px.has_value());
  EXPECT_EQ(r.region.value().width, 300);
  EXPECT_DOUBLE_EQ(r.walls[0].distance_m, 0.4);
  EXPECT_DOUBLE_EQ(r.walls[0].light, 1);
  EXPECT_DOUBLE_EQ(r.walls[1].distance_m, 0.612);
  EXPECT_DOUBLE_EQ(r.walls[1].light, 0.5);
  EXPECT_DOUBLE_EQ(r.walls[1].distance_sigma_m, 0.0005);
}

TEST(Recordings, MistakesAreNamedWithFileKeyValueAndLimit) {
  EXPECT_THAT(error_of([] { index({"wall_near"}); }),
              HasSubstr("wall_near: the folder's name says no distance"));
  EXPECT_THAT(error_of([] { index({"wall_0m"}); }), HasSubstr("0.01 to 100 m"));
  EXPECT_THAT(error_of([] { index({"wall_nanm"}); }), HasSubstr("0.01 to 100 m"));
  EXPECT_THAT(error_of([] { index({"wall_1m"}, "[\"wall_2m\"]\ndistance_m = 2\n"); }),
              HasSubstr("table [\"wall_2m\"]: there is no folder"));
  EXPECT_THAT(error_of([] { index({"wall_1m"}, "depth_units = 1\n"); }), HasSubstr("depth_unit_m"));
  EXPECT_THAT(error_of([] { index({"wall_1m"}, "\n[wall_1m]\ndistance_m = 1e9\n"); }),
              AllOf(HasSubstr("recordings.toml:3"), HasSubstr("distance_m"), HasSubstr("100")));
  EXPECT_THAT(error_of([] { index({"wall_1m"}, "region_px = [1, 2]\n"); }),
              HasSubstr("region_px has 2 numbers"));
  EXPECT_THAT(error_of([] { index(std::vector<std::string>(kMostFolders + 1, "wall_1m")); }),
              HasSubstr("the limit is 64"));
}

TEST(Recordings, TooFewDistancesOrFramesSayHowManyAreNeeded) {
  const TemporaryFolder folder;
  const auto fit = [&] { fit_sensor(read_recordings(folder.path()), rig_choice("d457")); };
  EXPECT_THAT(error_of(fit), HasSubstr("no recordings"));
  const Image<std::uint16_t> depth(640, 480, std::uint16_t{1000});
  for (const char* name : {"wall_1m", "wall_2m", "wall_3m"})
    write_png(folder.path() / name / "0.png", depth);
  EXPECT_THAT(error_of(fit), HasSubstr("3 wall folders; at least 4 distances"));
  write_png(folder.path() / "wall_4m" / "0.png", depth);
  EXPECT_THAT(error_of(fit), AllOf(HasSubstr("wall_1m: 1 PNG frames"), HasSubstr("at least 4")));
}

TEST(Recordings, FramesOfAnotherSizeKindOrModeAreNamed) {
  const TemporaryFolder folder;
  const auto fit = [&](const char* rig) {
    return error_of([&] { fit_sensor(read_recordings(folder.path()), rig_choice(rig)); });
  };
  for (const char* name : {"wall_1m", "wall_2m", "wall_3m", "wall_4m"}) {
    for (const char* file : {"0.png", "1.png", "2.png", "3.png"})
      write_png(folder.path() / name / file, Image<std::uint16_t>(320, 200, std::uint16_t{900}));
  }
  EXPECT_THAT(fit("d457"),
              AllOf(HasSubstr("320 x 200"), HasSubstr("640 x 480"), HasSubstr("focal_px")));
  EXPECT_THAT(fit("zed_hd720"), HasSubstr("has no depth camera"));
  write_file(folder.path() / "recordings.toml", "focal_px = 200\nregion_px = [200, 0, 200, 100]\n");
  EXPECT_THAT(fit("d457"), HasSubstr("200 x 100 pixels at 200, 0"));
  write_file(folder.path() / "recordings.toml", "focal_px = 200\n");
  write_png(folder.path() / "wall_3m/2.png", Image<std::uint16_t>(64, 48, std::uint16_t{900}));
  EXPECT_THAT(fit("d457"), AllOf(HasSubstr("wall_3m"), HasSubstr("64 x 48")));
  write_png(folder.path() / "wall_3m/2.png", Image<std::uint8_t>(320, 200, std::uint8_t{90}));
  EXPECT_THAT(fit("d457"), HasSubstr("2.png"));
}

TEST(Recordings, RawFramesAreGreyOfEightOrSixteenBits) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "a.png";
  write_png(file, Image<std::uint8_t>(4, 3, std::uint8_t{7}));
  EXPECT_EQ(read_raw_frame(file).bits, 8);
  EXPECT_EQ(read_raw_frame(file).codes(1, 1), 7);
  write_png(file, Image<std::uint16_t>(4, 3, std::uint16_t{700}));
  EXPECT_EQ(read_raw_frame(file).bits, 16);
  write_png(file, Image<Rgb8>(4, 3));
  EXPECT_THAT(error_of([&] { read_raw_frame(file); }), HasSubstr("developed colours"));
  write_file(file, "x");
  EXPECT_THAT(error_of([&] { read_raw_frame(file); }), HasSubstr("a.png"));
}

TEST(PresetPatch, ReplacesValuesAndKeepsWhoseCommentIsWhose) {
  const std::string toml =
      "# title\n\n# free: of both\na = 1\nb = 2\n[t]\n# sourced: there\nc = [1,\n  2]\nd = \"x # "
      "]\"\n";
  EXPECT_EQ(
      patched_preset(toml, {{"a", "5", "fitted: to x"}, {"t.c", "[3]", "fitted: to y"}}),
      "# title\n\n# fitted: to x\na = 5\n# free: of both\nb = 2\n[t]\n# fitted: to y\nc = [3]\n"
      "# sourced: there\nd = \"x # ]\"\n");
  EXPECT_TRUE(has_key(toml, "t.d"));
  EXPECT_THAT(error_of([&] { patched_preset(toml, {{"t.e", "1", ""}}); }), HasSubstr("t.e"));
}

TEST(RigChoice, APathIsReadInPlaceOfAPreset) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "mine.toml";
  write_file(file, rig_choice("d405").toml);
  const RigChoice mine = rig_choice(file.string());
  ASSERT_TRUE(mine.depth.has_value());
  EXPECT_EQ(mine.depth->baseline_m, active_stereo_preset("d405").baseline_m);
  EXPECT_EQ(rig_preset_names().size(), 5U);
  write_file(file, rig_choice("dslr_apsc_24mp").toml);
  EXPECT_TRUE(rig_choice(file.string()).cameras.has_value());
  EXPECT_EQ(photosites_choice(rig_choice(file.string()))->bits, 14);
  EXPECT_THAT(error_of([&] { rig_choice("d999"); }), HasSubstr("d457"));
  EXPECT_THAT(error_of([&] { rig_choice((folder.path() / "none.toml").string()); }),
              HasSubstr("none.toml"));
  write_file(file, "columns = 7\n");
  EXPECT_THAT(error_of([&] { rig_choice(file.string()); }), HasSubstr("mine.toml"));
}

}  // namespace
}  // namespace cousin
