#include <stdexcept>

#include "perception/splats/splat_start.h"
#include "tests/fuzz/fuzz_folder.h"

/// Any bytes as a PLY of points that Gaussians start from: points that give a model, or
/// std::runtime_error, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  constexpr std::size_t kMost = 10'000;
  StartPoints start;
  try {
    start = read_start_points(fuzz_file("points.ply", data, size), kMost);
  } catch (const std::runtime_error&) {
    return 0;
  }
  if (splats_from_points(start.points).splats.size() != start.points.size())
    throw std::logic_error("a point gave no Gaussian");
  return 0;
}
