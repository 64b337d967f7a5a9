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
constexpr std::string_view kDirections[] = {"axis", "approach"};

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

/// Boxes of one case.
struct CaseBoxes {
  std::span<const SpecimenRow> rows;
  std::span<const std::string_view> traits;

  std::int64_t count() const { return static_cast<std::int64_t>(rows.size() / traits.size()); }
  bool has(std::string_view name) const {
    return std::find(traits.begin(), traits.end(), std::string(name) + "_x") != traits.end();
  }
  /// Of those that have it measured.
  std::vector<Triple> triples(std::string_view name) const {
    std::vector<Triple> found;
    for (std::size_t i = 0; i + traits.size() <= rows.size(); i += traits.size()) {
      if (const auto triple = triple_of(rows.subspan(i, traits.size()), name))
        found.push_back(*triple);
    }
    return found;
  }
};

void add_place(const CaseBoxes& boxes, std::string_view place, const ScoreRow& base,
               std::vector<ScoreRow>& scores) {
  std::vector<double> off_m, aside_m;
  for (const Triple& triple : boxes.triples(place)) {
    const Eigen::Vector3d error_m = triple.measured - triple.truth;
    const Eigen::Vector3d sight = triple.truth.normalized();
    off_m.push_back(error_m.norm());
    aside_m.push_back((error_m - error_m.dot(sight) * sight).norm());
  }
  const std::string name(place);
  const auto add = [&](const char* metric, double value, const char* unit, std::int64_t n) {
    scores.push_back(measured_row(base, name + metric, value, unit, n));
  };
  const auto n = static_cast<std::int64_t>(off_m.size());
  if (n > 0) {
    add(".error_3d", quantile(off_m, 0.5), "m", n);
    add(".error_lateral", quantile(aside_m, 0.5), "m", n);
    add(".rmse_3d", root_mean_square(off_m), "m", n);
    add(".rmse_lateral", root_mean_square(aside_m), "m", n);
  }
  if (place != "cut") return;
  add(".within_2_mm", share_within(off_m, 0.002, boxes.count()), "1", boxes.count());
  add(".within_5_mm", share_within(off_m, 0.005, boxes.count()), "1", boxes.count());
  add(".within_10_mm", share_within(off_m, 0.010, boxes.count()), "1", boxes.count());
}

void add_direction(const CaseBoxes& boxes, std::string_view way, const ScoreRow& base,
                   std::vector<ScoreRow>& scores) {
  std::vector<double> turned_rad;
  for (const Triple& triple : boxes.triples(way))
    turned_rad.push_back(std::acos(
        std::clamp(triple.truth.normalized().dot(triple.measured.normalized()), -1.0, 1.0)));
  const std::string name(way);
  if (!turned_rad.empty())
    scores.push_back(measured_row(base, name + ".error_angle", quantile(turned_rad, 0.5), "rad",
                                  static_cast<std::int64_t>(turned_rad.size())));
  constexpr double kTenDegrees_rad = std::numbers::pi / 18;
  scores.push_back(measured_row(base, name + ".within_10_deg",
                                share_within(turned_rad, kTenDegrees_rad, boxes.count()), "1",
                                boxes.count()));
}

}  // namespace

bool is_of_place(std::string_view trait) {
  if (trait.size() < 3 || trait[trait.size() - 2] != '_') return false;
  if (trait.back() < 'x' || trait.back() > 'z') return false;
  const std::string_view name = trait.substr(0, trait.size() - 2);
  const auto is_in = [&](const auto& names) {
    return std::find(std::begin(names), std::end(names), name) != std::end(names);
  };
  return is_in(kPlaces) || is_in(kDirections);
}

void add_place_rows(std::span<const SpecimenRow> rows, std::span<const std::string_view> traits,
                    const ScoreRow& base, std::vector<ScoreRow>& scores) {
  if (rows.empty() || traits.empty()) return;
  const CaseBoxes boxes{rows, traits};
  for (const std::string_view place : kPlaces) {
    if (boxes.has(place)) add_place(boxes, place, base, scores);
  }
  for (const std::string_view way : kDirections) {
    if (boxes.has(way)) add_direction(boxes, way, base, scores);
  }
}

}  // namespace cousin
