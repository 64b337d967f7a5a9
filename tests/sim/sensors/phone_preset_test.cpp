#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "sim/sensors/phone.h"
#include "tests/places/places.h"

namespace cousin {
namespace {

TEST(PhonePreset, EveryNameLoadsAndMakesAPhone) {
  std::set<std::string> names;
  for (const std::string& name : phone_preset_names()) {
    EXPECT_TRUE(names.insert(name).second) << name << " is listed twice";
    const PhoneConfig config = phone_preset(name);
    const PhoneUnit unit = make_phone(config, Rng(1));
    EXPECT_EQ(unit.camera_at_infinity.width_px, config.width_px);
    EXPECT_EQ(report_of(config, unit).readout_s, config.readout_s);
  }
  EXPECT_THAT(names, testing::UnorderedElementsAre("phone_video_720p", "phone_video_1080p"));
}

TEST(PhonePreset, UnknownNameListsTheOnesThatExist) {
  try {
    phone_preset("phone_video_4k");
    FAIL() << "no error";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("phone_video_4k"));
    EXPECT_THAT(error.what(), testing::HasSubstr("phone_video_720p, phone_video_1080p"));
  }
}

TEST(PhonePreset, EveryNumberSaysWhereItComesFrom) {
  for (const std::string& name : phone_preset_names()) {
    std::ifstream file(source_folder() / ("sim/sensors/presets/" + name + ".toml"));
    ASSERT_TRUE(file) << name;
    std::string comment;
    for (std::string line; std::getline(file, line);) {
      if (line.empty()) comment.clear();
      if (line.starts_with("#")) comment = line.find(": ") < 12 ? line : comment + line;
      if (line.find(" = ") == std::string::npos || line.starts_with("#")) continue;
      EXPECT_TRUE(comment.starts_with("# sourced: ") || comment.starts_with("# fitted: ") ||
                  comment.starts_with("# free: "))
          << name << ": " << line << " has no source";
    }
  }
}

TEST(PhonePreset, ConfigurationSurvivesTomlOutAndIn) {
  PhoneConfig config = phone_preset("phone_video_720p");
  config.focal_m = 0.1 + 0.2;  // not a short decimal
  config.focal_m /= 100;
  PhoneConfig back;
  read_toml_text(to_toml(fields(config)), "round trip", fields(back), MissingKeys::error);
  EXPECT_EQ(to_toml(fields(back)), to_toml(fields(config)));
  EXPECT_EQ(back.focal_m, config.focal_m);
}

TEST(PhoneConfig, RejectsWhatCannotBeBuilt) {
  const auto rejects = [](auto change) {
    PhoneConfig config;
    config.width_px = 160;
    config.height_px = 90;
    change(config);
    EXPECT_THROW(make_phone(config, Rng(1)), std::invalid_argument);
  };
  rejects([](PhoneConfig& c) { c.focal_px_per_width = 0; });
  rejects([](PhoneConfig& c) { c.focal_px_per_width = std::numeric_limits<double>::quiet_NaN(); });
  rejects([](PhoneConfig& c) { c.width_px = 0; });
  rejects([](PhoneConfig& c) { c.full_well_e = -1; });
  rejects([](PhoneConfig& c) { c.bits = 17; });
  rejects([](PhoneConfig& c) { c.prnu = -0.1; });
  rejects([](PhoneConfig& c) { c.jpeg_quality = 101; });
  rejects([](PhoneConfig& c) { c.vignetting_a = -1; });
  rejects([](PhoneConfig& c) { c.distortion = {-3.0}; });                // folds inside the image
  rejects([](PhoneConfig& c) { c.distortion = {0, 0, 0, 0, 0, 0.1}; });  // opencv5 takes five
  rejects([](PhoneConfig& c) { c.distortion = {std::numeric_limits<double>::infinity()}; });
}

}  // namespace
}  // namespace cousin
