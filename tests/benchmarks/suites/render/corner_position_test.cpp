#include "benchmarks/suites/render/corner_position.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace cousin {
namespace {

TEST(RadiancePass, CornersAppearWhereTheyProjectThroughEveryLens) {
  for (const LensModel model :
       {LensModel::pinhole, LensModel::opencv5, LensModel::opencv8, LensModel::opencv12,
        LensModel::kannala_brandt4, LensModel::splined_stereographic}) {
    const CornerPositions found = measure_corner_positions(model);
    ASSERT_GT(found.corners, 60) << to_string(model);
    std::printf("%s: %d corners, bias %.4f %.4f px, RMS %.4f px\n",
                std::string(to_string(model)).c_str(), found.corners, found.bias_px.x(),
                found.bias_px.y(), found.rms_px);
    // Edges one pixel wide alias in the locator by 0.035 px a corner, of either sign: 0.003 px in
    // the mean.
    EXPECT_LT(found.bias_px.norm(), 0.02) << to_string(model);
    EXPECT_LT(found.rms_px, 0.05) << to_string(model);
  }
}

}  // namespace
}  // namespace cousin
