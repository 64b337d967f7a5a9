#include "benchmarks/suites/real/real_rows.h"

namespace cousin {

ScoreRow real_row(const std::string& scene, const std::string& case_name, const std::string& method,
                  const std::string& metric, double value, const std::string& unit,
                  std::int64_t n) {
  ScoreRow row;
  row.suite = "real";
  row.scene = scene;
  row.case_name = case_name;
  row.method = method;
  row.metric = metric;
  row.value = value;
  row.unit = unit;
  row.n = n;
  return row;
}

ScoreRow not_solved_row(const std::string& scene, const std::string& case_name,
                        const std::string& why) {
  ScoreRow row = real_row(scene, case_name, "ours", why, ScoreRow::kNone, "1", 0);
  row.status = ScoreStatus::not_solved;
  return row;
}

ReportShape cloud_shape(const std::string& name, const std::string& caption, const Cloud& cloud) {
  ReportShape shape{name, caption, {}, {}, {}};
  for (const CloudPoint& point : cloud) {
    shape.positions_m.push_back(point.position_m);
    shape.colors.push_back(point.color);
  }
  return shape;
}

}  // namespace cousin
