#include "benchmarks/tools/measure/measured_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace cousin {
namespace {

using testing::HasSubstr;

MeasuredSample one_seed(PrintScale scale) {
  SpecimenTraits seed;
  seed.instance = 3;
  seed.status = TraitStatus::ok;
  seed.traits = {
      {"length", "m", 0.010, 0.0001}, {"area", "m2", 200e-6, 4e-6}, {"volume", "m3", 250e-9, 5e-9}};
  SpecimenTraits lost;
  lost.instance = 4;
  lost.reason = "seen in 2 views, \"too few\"";
  return {"a", "a", {seed, lost}, std::move(scale)};
}

TEST(PrintScale, IsReadOverNominal) {
  const PrintScale of_100 = print_scale_of_ruler("97", 0.25);
  EXPECT_DOUBLE_EQ(of_100.factor, 0.97);
  EXPECT_DOUBLE_EQ(of_100.sigma, 0.0025);
  const PrintScale of_150 = print_scale_of_ruler("149.6/150", 0.3);
  EXPECT_DOUBLE_EQ(of_150.factor, 149.6 / 150);
  EXPECT_DOUBLE_EQ(of_150.sigma, 0.002);
  for (const char* bad :
       {"", "x", "99.7mm", "99.7/", "/100", "99.7/0", "nan", "inf", "9.97", "130"})
    EXPECT_THROW((void)print_scale_of_ruler(bad, 0.25), std::invalid_argument) << bad;
}

TEST(MeasuredRows, ABoardPrintedAt97PerCentMakesSeedsSmallerByThePowerOfTheirUnit) {
  const std::vector<MeasuredRow> rows = measured_rows(one_seed(print_scale_of_ruler("97", 0.25)));
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_NEAR(rows[0].value, 10 * 0.97, 1e-12);
  EXPECT_EQ(rows[0].unit, "m");
  EXPECT_NEAR(rows[1].value, 200 * 0.97 * 0.97, 1e-9);
  EXPECT_EQ(rows[1].unit, "m2");
  EXPECT_NEAR(rows[2].value, 250 * 0.97 * 0.97 * 0.97, 1e-9);
  EXPECT_EQ(rows[2].unit, "m3");
}

TEST(MeasuredRows, IntervalsHoldThePrintsDeviationToo) {
  const std::vector<MeasuredRow> exact = measured_rows(one_seed(exact_print()));
  EXPECT_NEAR(exact[0].high - exact[0].value, 1.959964 * 0.1, 1e-6);
  const std::vector<MeasuredRow> unchecked = measured_rows(one_seed(unchecked_print()));
  // 0.1 mm of its own, and 0.5 % of 10 mm.
  EXPECT_NEAR(unchecked[0].high - unchecked[0].value, 1.959964 * std::hypot(0.1, 0.05), 1e-6);
  // 5 mm3, and three times 0.5 % of 250 mm3.
  EXPECT_NEAR(unchecked[2].value - unchecked[2].low, 1.959964 * std::hypot(5, 3.75), 1e-5);
  EXPECT_NEAR(unchecked[0].own_sigma, 0.1, 1e-12);
}

TEST(TidyTable, HasARowATraitAndOneWithAReasonForASeedThatIsNotMeasured) {
  const std::vector<MeasuredRow> rows = measured_rows(one_seed(exact_print()));
  EXPECT_EQ(to_tidy_csv(rows, ""),
            "sample,seed,trait,unit,value,low,high,status,reason\n"
            "a,3,length,mm,10,9.804,10.196,ok,\n"
            "a,3,area,mm2,200,192.16,207.84,ok,\n"
            "a,3,volume,mm3,250,240.2,259.8,ok,\n"
            "a,4,,,,,,not_solved,\"seen in 2 views, \"\"too few\"\"\"\n");
  EXPECT_THAT(to_tidy_csv(rows, "cultivar"), HasSubstr("sample,cultivar,seed,"));
  EXPECT_THAT(to_tidy_csv(rows, "cultivar"), HasSubstr("a,a,3,length,"));
}

}  // namespace
}  // namespace cousin
