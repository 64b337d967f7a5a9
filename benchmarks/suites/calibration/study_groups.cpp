#include <algorithm>
#include <numeric>

#include "benchmarks/loop/run_config.h"
#include "benchmarks/suites/calibration/study_points.h"
#include "scenes/boards/boards_scene.h"

namespace cousin {
namespace {

/// Sensors in the order of how many photographs they take.
void sort_sensors(StudyGroup& group) {
  std::vector<std::size_t> order(group.sensors.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return group.sensor_views[a] > group.sensor_views[b];
  });
  std::vector<std::vector<std::string>> sensors;
  std::vector<int> views;
  std::vector<std::size_t> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    sensors.push_back(group.sensors[order[i]]);
    views.push_back(group.sensor_views[order[i]]);
    place[order[i]] = i;
  }
  for (std::size_t& sensor : group.sensor_of_point) sensor = place[sensor];
  group.sensors = std::move(sensors);
  group.sensor_views = std::move(views);
  group.views = group.sensor_views.front();
}

/// The configuration with all defaults in it: two lists of keys may say the same.
std::string resolved(std::vector<std::string> sets, const std::vector<std::string>& more) {
  sets.insert(sets.end(), more.begin(), more.end());
  return resolved_toml(run_config(boards_row(), sets));
}

}  // namespace

std::vector<StudyGroup> study_groups(bool quick) {
  std::vector<StudyGroup> groups;
  std::vector<std::string> lights;                // resolved, of each group
  std::vector<std::vector<std::string>> sensors;  // resolved, of each group's sensors
  for (StudyPoint& point : study_points(quick)) {
    std::vector<std::string> sets = study_sets();
    sets.insert(sets.end(), point.sets.begin(), point.sets.end());
    const std::string light = resolved(sets, {});
    const auto g =
        static_cast<std::size_t>(std::find(lights.begin(), lights.end(), light) - lights.begin());
    if (g == groups.size()) {
      groups.push_back({sets, 0, {}, {}, {}, {}});
      lights.push_back(light);
      sensors.emplace_back();
    }
    StudyGroup& group = groups[g];
    const std::string sensor = resolved(sets, point.sensor_sets);
    const auto s = static_cast<std::size_t>(
        std::find(sensors[g].begin(), sensors[g].end(), sensor) - sensors[g].begin());
    if (s == group.sensors.size()) {
      group.sensors.push_back(point.sensor_sets);
      group.sensor_views.push_back(0);
      sensors[g].push_back(sensor);
    }
    group.sensor_views[s] = std::max(group.sensor_views[s], point.views);
    group.sensor_of_point.push_back(s);
    group.points.push_back(std::move(point));
  }
  for (StudyGroup& group : groups) sort_sensors(group);
  return groups;
}

}  // namespace cousin
