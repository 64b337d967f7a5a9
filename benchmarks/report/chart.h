#pragma once

#include <limits>
#include <string>
#include <vector>

namespace cousin {

/// A point, with its 95 % interval where there is one.
struct ChartPoint {
  double x = 0, y = 0;
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

/// Points, or a line through them in the order given.
struct ChartSeries {
  std::string name;
  bool is_line = false;
  std::vector<ChartPoint> points;
};

/// Quantities against each other, in the units that the axes' titles say. Points that a logarithmic
/// axis has no place for, or that are not finite, are left out.
struct Chart {
  std::string title;
  std::vector<std::string> caption;  ///< lines
  std::string x_title, y_title;      ///< "distance (m)"
  bool log_x = false, log_y = false;
  std::vector<ChartSeries> series;
};

}  // namespace cousin
