#include "sim/dataset/depth_units.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <vector>

#include "sim/dataset/text_fields.h"

namespace cousin {
namespace {

constexpr double kLeastMedian_m = 0.01, kMostMedian_m = 20;
constexpr std::size_t kMostOfMedian = std::size_t{1} << 20;

}  // namespace

std::optional<double> median_depth(const Capture& capture, std::size_t sensor,
                                   DepthMeasure measure) {
  std::size_t all = 0, at = 0;
  for (const Frame& frame : capture.frames) all += frame.sensors[sensor].depth.size();
  const std::size_t step = all / kMostOfMedian + 1;
  std::vector<double> values;
  for (const Frame& frame : capture.frames) {
    const SensorFrame& from = frame.sensors[sensor];
    const double scale = measure == DepthMeasure::units ? 1 : from.depth_unit_m;
    for (const std::uint16_t value : from.depth) {
      if (at++ % step == 0 && value != 0) values.push_back(scale * value);
    }
  }
  if (values.empty()) return std::nullopt;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::string usual_depth_units(double median_units) {
  struct Unit {
    double metres;
    const char* text;
    const char* whose;
  };
  constexpr std::array<Unit, 3> kUsual = {{{0.001, "0.001", "millimetres, RealSense and Kinect"},
                                           {0.0002, "0.0002", "TUM"},
                                           {0.0001, "0.0001", "0.1 mm"}}};
  std::string text = "Give --depth-unit, metres a unit: ";
  for (const Unit& unit : kUsual) {
    text += std::string(unit.metres == kUsual[0].metres ? "" : ", ") + unit.text + " (" +
            unit.whose + ": " + short_text(median_units * unit.metres) + " m)";
  }
  return text;
}

void check_median_depth(const Capture& capture, std::size_t sensor, const std::string& place,
                        const std::string& advice) {
  const std::optional<double> metres = median_depth(capture, sensor, DepthMeasure::metres);
  if (!metres || (*metres >= kLeastMedian_m && *metres <= kMostMedian_m)) return;
  throw std::runtime_error(
      place + ": the median depth is " + short_text(*metres) +
      " m, outside [0.01, 20] m: depth read in the wrong unit? " +
      (advice.empty() ? usual_depth_units(*median_depth(capture, sensor, DepthMeasure::units))
                      : advice));
}

}  // namespace cousin
