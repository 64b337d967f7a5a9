#include <algorithm>
#include <cmath>
#include <string>

#include "benchmarks/suites/calibration/studies.h"
#include "benchmarks/suites/calibration/study_points.h"

namespace cousin {
namespace {

/// One error of one method at one point; null where it was not measured.
const ScoreRow* find_row(const std::vector<ScoreRow>& rows, const StudyPoint& point,
                         const std::string& method, const char* metric) {
  for (const ScoreRow& row : rows) {
    if (row.scene == point.axis && row.case_name == point.name() && row.method == method &&
        row.metric == metric && std::isfinite(row.value))
      return &row;
  }
  return nullptr;
}

std::string factory_of(const StudyPoint& point) {
  for (const StudyMethod& method : point.methods) {
    if (method.is_factory) return method.name;
  }
  return {};
}

std::vector<StudyPoint> points_of(const std::string& axis) {
  std::vector<StudyPoint> points = study_points(false);
  std::erase_if(points, [&](const StudyPoint& point) { return point.axis != axis; });
  return points;
}

/// The drift from which the device's own lens is the worse one.
ScoreRow drift_row(const std::vector<ScoreRow>& rows, const std::vector<StudyPoint>& points,
                   const StudyMethod& fresh, const char* metric) {
  ScoreRow result;
  result.suite = "calibration";
  result.scene = points.front().axis;
  result.case_name = points.front().axis + ", where a fresh calibration beats the device's lens";
  result.method = fresh.name;
  result.metric = std::string(metric) + ".crossing";
  result.unit = points.front().unit;
  result.status = ScoreStatus::not_solved;
  double last_x = 0, last_gain = 0;
  bool has_last = false;
  for (const StudyPoint& point : points) {
    const ScoreRow* own = find_row(rows, point, fresh.name, metric);
    const ScoreRow* factory = find_row(rows, point, factory_of(point), metric);
    if (own == nullptr || factory == nullptr) continue;
    result.seed = own->seed;
    result.n = std::max<std::int64_t>(result.n, own->n);
    const double gain = factory->value - own->value;
    if (gain > 0) {
      result.value =
          has_last ? last_x + (point.x - last_x) * last_gain / (last_gain - gain) : point.x;
      result.status = ScoreStatus::ok;
      break;
    }
    last_x = point.x;
    last_gain = gain;
    has_last = true;
  }
  return result;
}

/// The fewest photographs of the sweep that beat the device's lens.
ScoreRow photographs_row(const std::vector<ScoreRow>& rows, const std::vector<StudyPoint>& points,
                         const StudyMethod& method, const char* metric) {
  ScoreRow result = drift_row(rows, points, method, metric);
  result.case_name = "photographs with which a fresh calibration beats the device's lens";
  result.metric = std::string(metric) + ".fewest photographs";
  result.unit = "1";
  if (result.status == ScoreStatus::ok) {
    const auto at = std::find_if(points.begin(), points.end(),
                                 [&](const StudyPoint& p) { return p.x >= result.value - 1e-9; });
    if (at != points.end()) result.value = at->x;
  }
  return result;
}

}  // namespace

std::vector<ScoreRow> crossing_rows(const std::vector<ScoreRow>& pooled) {
  std::vector<ScoreRow> rows;
  const auto add = [&](const ScoreRow& row) {
    if (row.n > 0) rows.push_back(row);
  };
  for (const char* metric : {"projection.rms", "fruit.position", "seed.length"}) {
    for (const char* axis : {"warming", "knock"}) {
      const std::vector<StudyPoint> points = points_of(axis);
      for (const StudyMethod& method : points.front().methods) {
        if (method.is_fresh) add(drift_row(pooled, points, method, metric));
      }
    }
    const std::vector<StudyPoint> points = points_of("images");
    for (const StudyMethod& method : points.front().methods) {
      if (!method.is_factory) add(photographs_row(pooled, points, method, metric));
    }
  }
  return rows;
}

}  // namespace cousin
