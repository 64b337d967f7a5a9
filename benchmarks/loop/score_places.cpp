#include "benchmarks/loop/score_places.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "benchmarks/loop/score_geometry.h"
#include "benchmarks/score/order_statistics.h"

namespace cousin {
namespace {

constexpr std::string_view kPlaces[] = {"centre", "calyx", "cut"};
constexpr std::string_view kAxis = "axis";

/// Values of NAME_x, NAME_y, NAME_z of one box.
struct Triple {
  Eigen::Vector3d truth, measured;
};
std::optional<Triple> triple_of(std::span<const SpecimenRow> box, std::string_view name) {
  Triple triple;
  for (int k = 0; k < 3; ++k) {
    const std::string wanted = std::string(name) + "_" + "xyz"[k];
    const auto row = std::find_if(box.begin(), box.end(),
                                  [&](const SpecimenRow& one) { return one.trait == wanted; });
    if (row == box.end() || row->status != ScoreStatus::ok) return std::nullopt;
    triple.truth[k] = row->truth;
    triple.measured[k] = row->measured;
  }
  return triple;
}

double root_mean_square(const std::vector<double>& values) {
  double squares = 0;
  for (const double v : values) squares += v * v;
  return std::sqrt(squares / static_cast<double>(values.size()));
}

double share_within(const std::vector<double>& values, double limit, std::int64_t all) {
  const auto within =
      std::count_if(values.begin(), values.end(), [&](double v) { return v <= limit; });
  return static_cast<double>(within) / static_cast<double>(all);
}

}  // namespace

bool is_of_place(std::string_view trait) {
  if (trait.size() < 3 || trait[trait.size() - 2] != '_') return false;
  const std::string_view name = trait.substr(0, trait.size() - 2);
  return name == kAxis ||
         std::find(std::begin(kPlaces), std::end(kPlaces), name) != std::end(kPlaces);
}

void add_place_rows(std::span<const SpecimenRow> rows, std::span<const std::string_view> traits,
                    const ScoreRow& base, std::vector<ScoreRow>& scores) {
  if (traits.empty()) return;
  const std::size_t boxes = rows.size() / traits.size();
  const auto all = static_cast<std::int64_t>(boxes);
  const auto has = [&](std::string_view name) {
    return std::find(traits.begin(), traits.end(), std::string(name) + "_x") != traits.end();
  };
  const auto add = [&](const std::string& metric, double value, const char* unit, std::int64_t n) {
    scores.push_back(measured_row(base, metric, value, unit, n));
  };
  for (const std::string_view place : kPlaces) {
    if (!has(place)) continue;
    std::vector<double> off_m, aside_m;
    for (std::size_t i = 0; i < boxes; ++i) {
      const auto triple = triple_of(rows.subspan(i * traits.size(), traits.size()), place);
      if (!triple) continue;
      const Eigen::Vector3d error_m = triple->measured - triple->truth;
      const Eigen::Vector3d sight = triple->truth.normalized();
      off_m.push_back(error_m.norm());
      aside_m.push_back((error_m - error_m.dot(sight) * sight).norm());
    }
    const std::string name(place);
    const auto n = static_cast<std::int64_t>(off_m.size());
    if (n > 0) {
      add(name + ".error_3d", quantile(off_m, 0.5), "m", n);
      add(name + ".error_lateral", quantile(aside_m, 0.5), "m", n);
      add(name + ".rmse_3d", root_mean_square(off_m), "m", n);
      add(name + ".rmse_lateral", root_mean_square(aside_m), "m", n);
    }
    if (place != "cut" || all == 0) continue;
    add("cut.within_2_mm", share_within(off_m, 0.002, all), "1", all);
    add("cut.within_5_mm", share_within(off_m, 0.005, all), "1", all);
    add("cut.within_10_mm", share_within(off_m, 0.010, all), "1", all);
  }
  if (!has(kAxis) || all == 0) return;
  std::vector<double> turned_rad;
  for (std::size_t i = 0; i < boxes; ++i) {
    const auto triple = triple_of(rows.subspan(i * traits.size(), traits.size()), kAxis);
    if (triple)
      turned_rad.push_back(std::acos(
          std::clamp(triple->truth.normalized().dot(triple->measured.normalized()), -1.0, 1.0)));
  }
  if (!turned_rad.empty())
    add("axis.error_angle", quantile(turned_rad, 0.5), "rad",
        static_cast<std::int64_t>(turned_rad.size()));
  add("axis.within_10_deg", share_within(turned_rad, std::numbers::pi / 18, all), "1", all);
}

}  // namespace cousin
