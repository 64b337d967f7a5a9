// The table of pipelines says what their configurations take.
#include "perception/pipelines/pipeline_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "perception/pipelines/stage_table.h"
#include "sim/types/trait_table.h"

namespace cousin {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(PipelineTable, EachRowIsOfItsConfigurationAndNamesWhatThereIs) {
  std::set<std::string_view> names, scenes;
  for (const PipelineRow* each : pipeline_table()) {
    const PipelineRow& row = *each;
    SCOPED_TRACE(row.name);
    EXPECT_TRUE(names.insert(row.name).second);
    EXPECT_EQ(&row_of(row.defaults()), &row);
    EXPECT_EQ(&pipeline_row(row.name), &row);
    EXPECT_FALSE(row.help.empty());
    for (const std::string_view scene : row.scenes) {
      const bool is_first = scenes.insert(scene).second;
      EXPECT_EQ(pipeline_of_scene(scene) == &row, is_first) << scene;
    }
    for (const std::string_view stage : row.order) EXPECT_NO_THROW(stage_row(stage));
    for (const std::string_view trait : row.traits) EXPECT_NO_THROW(trait_row(trait));
    EXPECT_EQ(row.traits.empty(),
              row.traits_of == TraitsOf::nothing || row.traits_of == TraitsOf::depths);
    for (const std::string_view stage : row.from_outside)
      EXPECT_NE(std::find(row.order.begin(), row.order.end(), stage), row.order.end()) << stage;
  }
  EXPECT_EQ(pipeline_row("views").name, "scene");
  EXPECT_EQ(pipeline_of_scene("moon"), nullptr);
  EXPECT_THAT([] { (void)pipeline_row("moon"); },
              ThrowsMessage<std::invalid_argument>(HasSubstr(pipeline_names())));
}

TEST(PipelineTable, ASettingThatTheMethodDoesNotReadIsSaidToBe) {
  const auto unused = [](const char* name, const std::vector<std::string>& sets) {
    PipelineConfig config = pipeline_row(name).defaults();
    for (const std::string& set : sets) set_field(fields(config), set);
    return unused_settings(config);
  };
  using testing::ElementsAre;
  using testing::IsEmpty;
  EXPECT_THAT(unused("strawberries", {"method=paper", "fit.odd_scale=3"}),
              ElementsAre(HasSubstr("fit.odd_scale is not used by method paper")));
  EXPECT_THAT(unused("strawberries", {"fit.odd_scale=3"}), IsEmpty());
  EXPECT_THAT(unused("apples", {"method=hull", "fit.odd_scale=3"}), ElementsAre(HasSubstr("hull")));
  EXPECT_THAT(unused("maize", {"method=triangulation", "match_images=false"}),
              ElementsAre(HasSubstr("match_images")));
  EXPECT_THAT(unused("stereo", {"method=opencv", "stereo.radius_px=6"}),
              ElementsAre(HasSubstr("stereo.radius_px")));
  EXPECT_THAT(unused("stereo", {"method=opencv", "stereo.range_px=64"}), IsEmpty());
  EXPECT_THAT(unused("stereo", {"method=opencv", "cloud_sigma=0.1"}),
              ElementsAre(HasSubstr("cloud_sigma")));
  EXPECT_THAT(unused("strawberries", {"method=cone", "fit.odd_scale=3", "fit.widen=1"}),
              ElementsAre(HasSubstr("fit.odd_scale")));
}

TEST(PipelineTable, EveryMethodIsTakenAndSaysWhatItReads) {
  for (const PipelineRow* each : pipeline_table()) {
    const PipelineRow& row = *each;
    for (const MethodRow& method : row.methods) {
      SCOPED_TRACE(std::string(row.name) + "/" + std::string(method.name));
      PipelineConfig config = row.defaults();
      set_field(fields(config), "method=" + std::string(method.name));
      EXPECT_NO_THROW(validate(config));
      EXPECT_EQ(method_of(config), method.name);
      EXPECT_FALSE(method.help.empty());
      const PipelineNeeds needed = needs(config);
      EXPECT_FALSE(needed.images.empty());
      for (const std::string& stage : needed.stages)
        EXPECT_NE(std::find(row.order.begin(), row.order.end(), stage), row.order.end()) << stage;
    }
    PipelineConfig config = row.defaults();
    EXPECT_EQ(method_of(config), row.methods.front().name);
    // The message names the methods: as many as the table has.
    try {
      set_field(fields(config), "method=moon");
      FAIL() << "a method of no row was taken";
    } catch (const std::invalid_argument& error) {
      for (const MethodRow& method : row.methods)
        EXPECT_THAT(error.what(), HasSubstr(std::string(method.name)));
    }
  }
}

TEST(PipelineTable, StagesOfEachPipelineAreThoseThatItNeedsButThoseFromOutside) {
  Capture capture;
  capture.frames.resize(1);
  capture.frames[0].sensors.resize(1);
  for (const PipelineRow* each : pipeline_table()) {
    const PipelineRow& row = *each;
    SCOPED_TRACE(row.name);
    const PipelineConfig config = row.defaults();
    const Stages stages = stages_for(config, capture, 1);
    for (const std::string& stage : needs(config).stages) {
      const bool is_outside = std::find(row.from_outside.begin(), row.from_outside.end(), stage) !=
                              row.from_outside.end();
      EXPECT_NE(stage_row(stage).is_there(stages), is_outside) << stage;
    }
  }
}

}  // namespace
}  // namespace cousin
