#include "sim/types/trait_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace cousin {
namespace {

TEST(TraitTable, NamesAreOnceAndUnitsFit) {
  std::set<std::string_view> names;
  for (const TraitRow& row : trait_table()) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_GT(row.factor, 0) << row.name;
    // A number without a unit is shown as it is or in percent.
    if (row.unit == "1")
      EXPECT_EQ(row.factor, row.shown == "%" ? 100 : 1) << row.name;
    else
      EXPECT_FALSE(row.shown.empty()) << row.name;
    EXPECT_TRUE(row.unit != "1" || row.shown.empty() || row.shown == "%") << row.name << row.shown;
  }
}

TEST(TraitTable, ANameThatNoRowHasIsToldFromOneThatHas) {
  EXPECT_EQ(find_trait("colour"), nullptr);
  EXPECT_EQ(trait_row("volume").factor, 1e9);
  EXPECT_THAT([] { trait_row("colour"); },
              testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr("length, width")));
}

}  // namespace
}  // namespace cousin
