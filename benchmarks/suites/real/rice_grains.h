#pragma once

#include <filesystem>

#include "benchmarks/suites/real/real_rows.h"

namespace cousin {

/// Metres per pixel that a JPEG's JFIF header states; NaN if it states none.
double stated_m_per_px(const std::filesystem::path& jpeg);

/// Photographs of real rice in the husk beside paper strips of 100 mm: length and width of each
/// single grain by its rectangle of least area, beside the same of the rice cultivars of the scene.
/// The real varieties are unknown, so only kind and spread of the distributions can be compared.
/// Writes out/rice_Test1_100mm_ruler.png and so on: green = measured, red = touching, blue = strip.
RealPart rice_grains(const std::filesystem::path& real_data, const std::filesystem::path& out,
                     bool quick);

}  // namespace cousin
