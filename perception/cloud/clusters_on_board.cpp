#include <algorithm>
#include <cmath>
#include <limits>

#include "perception/cloud/clusters.h"
#include "perception/cloud/point_grid.h"

namespace cousin {
namespace {

double saturation(Rgb8 c) {
  const int high = std::max({c.r, c.g, c.b}), low = std::min({c.r, c.g, c.b});
  return high > 0 ? static_cast<double>(high - low) / high : 0;
}

bool faces_up(const CloudPoint& p) {
  constexpr float kSteep = 0.5F;  // 60 degrees; an unknown normal is zero and counts as up
  return p.normal.squaredNorm() == 0 || p.normal.z() > kSteep;
}

/// Groups of the chosen points, linked by steps of at most `distance_m`; -1 for the others. Numbers
/// start at `first`.
std::vector<int> groups_of(const Cloud& cloud, const std::vector<bool>& chosen, double distance_m,
                           int first) {
  std::vector<Eigen::Vector3f> points_m;
  std::vector<std::size_t> source;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!chosen[i]) continue;
    points_m.push_back(cloud[i].position_m);
    source.push_back(i);
  }
  const std::vector<int> group = euclidean_groups(points_m, distance_m);
  std::vector<int> instance(cloud.size(), -1);
  for (std::size_t i = 0; i < source.size(); ++i) instance[source[i]] = first + group[i];
  return instance;
}

int group_count(const std::vector<int>& instance) {
  return instance.empty() ? 0 : *std::max_element(instance.begin(), instance.end()) + 1;
}

/// Takes -1 where the top of a group (95 % of its points lie below) is lower than any object: noise
/// of the board's own edge.
void drop_low_groups(const Cloud& cloud, double min_top_m, std::vector<int>& instance) {
  std::vector<std::vector<float>> heights(static_cast<std::size_t>(group_count(instance)));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (instance[i] >= 0)
      heights[static_cast<std::size_t>(instance[i])].push_back(cloud[i].position_m.z());
  }
  std::vector<bool> low(heights.size());
  for (std::size_t g = 0; g < heights.size(); ++g) {
    if (heights[g].empty()) continue;
    const auto top = heights[g].begin() + static_cast<std::ptrdiff_t>(heights[g].size() * 95 / 100);
    std::nth_element(heights[g].begin(), top, heights[g].end());
    low[g] = *top < static_cast<float>(min_top_m);
  }
  for (int& i : instance) {
    if (i >= 0 && low[static_cast<std::size_t>(i)]) i = -1;
  }
}

/// Takes -1 for groups far smaller than the largest: patches of a seed's side that its core does
/// not reach.
void drop_small_groups(double min_share, std::vector<int>& instance) {
  std::vector<std::size_t> size(static_cast<std::size_t>(group_count(instance)));
  for (const int i : instance) {
    if (i >= 0) ++size[static_cast<std::size_t>(i)];
  }
  const std::size_t largest = size.empty() ? 0 : *std::max_element(size.begin(), size.end());
  for (int& i : instance) {
    if (i >= 0 && static_cast<double>(size[static_cast<std::size_t>(i)]) <
                      min_share * static_cast<double>(largest))
      i = -1;
  }
}

/// Upward faces of objects: between two seeds that nearly touch, stereo smears the gap at their
/// sides, not on top. Coloured ones first; grey ones only where no colour is near, so that board
/// seen at a seed's edge links nothing.
std::vector<int> core_groups(const BoardClusterConfig& config, const Cloud& cloud,
                             const std::vector<bool>& saturated) {
  std::vector<bool> colored(cloud.size()), grey(cloud.size());
  std::vector<Eigen::Vector3f> colored_m;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const bool high =
        cloud[i].position_m.z() >= static_cast<float>(config.min_height_m) && faces_up(cloud[i]);
    colored[i] = high && saturated[i];
    grey[i] = high && !saturated[i];
    if (colored[i]) colored_m.push_back(cloud[i].position_m);
  }
  const PointGrid grid(colored_m, config.cluster_distance_m);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!grey[i]) continue;
    bool near = false;
    grid.for_neighbours(cloud[i].position_m, [&](std::size_t) { near = true; });
    grey[i] = !near;
  }
  std::vector<int> instance = groups_of(cloud, colored, config.core_distance_m, 0);
  const std::vector<int> of_grey =
      groups_of(cloud, grey, config.core_distance_m, group_count(instance));
  for (std::size_t i = 0; i < cloud.size(); ++i) instance[i] = std::max(instance[i], of_grey[i]);
  drop_low_groups(cloud, config.min_top_m, instance);
  drop_small_groups(config.min_share, instance);
  return instance;
}

/// Of each group the median of its points' saturations.
std::vector<double> median_saturations(const Cloud& cloud, const std::vector<int>& instance) {
  std::vector<std::vector<double>> all(static_cast<std::size_t>(group_count(instance)));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (instance[i] >= 0)
      all[static_cast<std::size_t>(instance[i])].push_back(saturation(cloud[i].color));
  }
  std::vector<double> medians;
  for (std::vector<double>& values : all) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    medians.push_back(values.empty() ? 0 : *middle);
  }
  return medians;
}

/// Points of an object's own kind of colour join the core they are nearest to: coloured ones down
/// to `low_height_m`, grey ones down to `min_height_m`. @param of_core  median saturation of each
void join_cores(const BoardClusterConfig& config, const Cloud& cloud,
                const std::vector<bool>& saturated, const std::vector<double>& of_core,
                std::vector<int>& instance) {
  std::vector<Eigen::Vector3f> core_m;
  std::vector<std::size_t> source;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (instance[i] < 0) continue;
    core_m.push_back(cloud[i].position_m);
    source.push_back(i);
  }
  const PointGrid grid(core_m, config.cluster_distance_m);
  const std::vector<int> core = instance;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f& p = cloud[i].position_m;
    const double lowest_m = saturated[i] ? config.low_height_m : config.min_height_m;
    if (core[i] >= 0 || p.z() < static_cast<float>(lowest_m)) continue;
    float nearest = std::numeric_limits<float>::infinity();
    grid.for_neighbours(p, [&](std::size_t other) {
      const float distance = (core_m[other] - p).squaredNorm();
      const auto own = static_cast<std::size_t>(core[source[other]]);
      if (distance < nearest && saturated[source[other]] == saturated[i] &&
          saturation(cloud[i].color) >= config.join_saturation * of_core[own]) {
        nearest = distance;
        instance[i] = core[source[other]];
      }
    });
  }
}

/// Drops groups with too few points and numbers the others by their first point.
int renumber(int min_points, std::vector<int>& instance) {
  const int groups = instance.empty() ? 0 : *std::max_element(instance.begin(), instance.end()) + 1;
  std::vector<int> size(static_cast<std::size_t>(groups)), number(size.size(), -1);
  for (const int i : instance) {
    if (i >= 0) ++size[static_cast<std::size_t>(i)];
  }
  int count = 0;
  for (int& i : instance) {
    if (i < 0) continue;
    const auto group = static_cast<std::size_t>(i);
    if (size[group] >= min_points && number[group] < 0) number[group] = count++;
    i = number[group];
  }
  return count;
}

}  // namespace

Clusters cluster_on_board(const Cloud& cloud, const BoardClusterConfig& config) {
  validate(config);
  Clusters clusters;
  std::copy_if(cloud.begin(), cloud.end(), std::back_inserter(clusters.cloud),
               [](const CloudPoint& p) { return p.position_m.allFinite(); });
  std::vector<bool> saturated(clusters.cloud.size());
  for (std::size_t i = 0; i < clusters.cloud.size(); ++i) {
    saturated[i] = saturation(clusters.cloud[i].color) >= config.min_saturation;
  }
  clusters.instance = core_groups(config, clusters.cloud, saturated);
  const std::vector<double> of_core = median_saturations(clusters.cloud, clusters.instance);
  for (int round = 0; round < config.join_rounds; ++round) {
    const std::vector<int> before = clusters.instance;
    join_cores(config, clusters.cloud, saturated, of_core, clusters.instance);
    if (clusters.instance == before) break;
  }
  clusters.count = renumber(config.cluster_min_points, clusters.instance);
  return clusters;
}

}  // namespace cousin
