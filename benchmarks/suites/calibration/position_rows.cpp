#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "benchmarks/score/trait_statistics.h"
#include "benchmarks/suites/calibration/calibration_row.h"
#include "benchmarks/suites/calibration/fruit_positions.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

constexpr const char* kScene = "positions of fruits";

/// Distances whose errors are averaged, of the point that was held to the tape.
struct Bin {
  const char* name;
  double low_m, high_m;
};
constexpr std::array<Bin, 4> kBins = {{{"0.3 to 0.6 m", 0.2, 0.7},
                                       {"0.3 to 0.4 m", 0.2, 0.4},
                                       {"0.4 to 0.5 m", 0.4, 0.5},
                                       {"0.5 to 0.6 m", 0.5, 0.7}}};

const Vector3d& at(const FruitPosition& position, PositionStep step) {
  return position.step_m[static_cast<std::size_t>(step)];
}

/// One point before and after.
struct Moved {
  Vector3d from_m, to_m;
  double depth_m = 0;  ///< of the point held
  int run = 0;
};

void add_rows(std::vector<ScoreRow>& rows, const std::string& method, const std::string& unit_name,
              const std::vector<Moved>& all, std::uint64_t seed) {
  const std::array<const char*, 4> coordinates = {"x", "y", "z", "range"};
  for (const Bin& bin : kBins) {
    for (std::size_t c = 0; c < coordinates.size(); ++c) {
      const auto of = [&](const Vector3d& p) {
        return c == 3 ? p.norm() : p(static_cast<Eigen::Index>(c));
      };
      std::vector<TraitPair> pairs;
      double sum = 0;
      for (const Moved& m : all) {
        if (m.depth_m < bin.low_m || m.depth_m >= bin.high_m || !m.to_m.allFinite()) continue;
        pairs.push_back({of(m.from_m), of(m.to_m), ScoreRow::kNone, std::to_string(m.run)});
        sum += std::abs(of(m.to_m) - of(m.from_m));
      }
      if (pairs.size() < 2) continue;
      const std::string name = coordinates[c];
      const ScoreRow row = calibration_row(kScene, unit_name + ", " + bin.name, method, seed);
      const TraitStatistics s = trait_statistics(
          pairs, Rng(seed).fork("positions").fork(method).fork(bin.name).fork(name));
      rows.push_back(with_interval(row, name + ".rmse", "m", s.rmse, s.n));
      rows.push_back(with_interval(row, name + ".bias", "m", s.bias, s.n));
      rows.push_back(
          with_interval(row, name + ".mae", "m", {sum / static_cast<double>(pairs.size())}, s.n));
    }
  }
}

using Runs = std::vector<std::vector<FruitPosition>>;
using Put = std::function<Vector3d(const FruitPosition&)>;

std::vector<Moved> moved(const Runs& runs, const Put& from, const Put& to) {
  std::vector<Moved> all;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    for (const FruitPosition& p : runs[r])
      all.push_back({from(p), to(p), at(p, PositionStep::held).z(), static_cast<int>(r)});
  }
  return all;
}

/// Turns the measured points of each run onto the true ones: axes that were laid by what the
/// camera shows.
void turn_to_fit(std::vector<Moved>& all, std::size_t runs) {
  for (std::size_t r = 0; r < runs; ++r) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    const auto counts = [&](const Moved& m) {
      return m.run == static_cast<int>(r) && m.to_m.allFinite();
    };
    for (const Moved& m : all) {
      if (counts(m)) sum += m.from_m * m.to_m.transpose();
    }
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d u = svd.matrixU();
    if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) *= -1;
    const Eigen::Matrix3d turn = u * svd.matrixV().transpose();
    for (Moved& m : all) {
      if (counts(m)) m.to_m = turn * m.to_m;
    }
  }
}

/// Equation 4 by the paper's lens, and by its distortion as well.
Vector3d by_paper(const FruitPosition& p, bool is_straightened) {
  const Camera lens = strawberry_paper_lens();
  const double z = at(p, PositionStep::pinhole).z();
  if (is_straightened) {
    const auto ray = unproject(lens, p.box_px);
    return ray ? Vector3d(z / ray->z() * *ray) : Vector3d::Constant(ScoreRow::kNone);
  }
  return {z * (p.box_px.x() - lens.cx_px) / lens.fx_px,
          z * (p.box_px.y() - lens.cy_px) / lens.fy_px, z};
}

}  // namespace

std::vector<ScoreRow> position_rows(const Runs& runs, const std::string& unit_name,
                                    std::uint64_t seed) {
  const auto step = [](PositionStep s) -> Put {
    return [s](const FruitPosition& p) { return at(p, s); };
  };
  std::vector<ScoreRow> rows;
  int count = 0, with_depth = 0;
  for (const auto& run : runs) {
    for (const FruitPosition& p : run) {
      ++count;
      with_depth += p.has_depth;
    }
  }
  if (count == 0) return rows;
  ScoreRow share = calibration_row(kScene, unit_name, "as the paper", seed);
  share.metric = "points with depth, share";
  share.value = with_depth / static_cast<double>(count);
  share.n = count;
  rows.push_back(share);
  add_rows(rows, "as the paper", unit_name,
           moved(runs, step(PositionStep::tape), step(PositionStep::pinhole)), seed);
  add_rows(rows, "with the lens's distortion", unit_name,
           moved(runs, step(PositionStep::tape), step(PositionStep::calibrated)), seed);
  add_rows(rows, kHeldUnderBox, unit_name,
           moved(
               runs,
               [](const FruitPosition& p) -> Vector3d {
                 return at(p, PositionStep::box) + at(p, PositionStep::tape) -
                        at(p, PositionStep::held);
               },
               step(PositionStep::pinhole)),
           seed);
  struct Share {
    const char* name;
    PositionStep from, to;
  };
  for (const Share& s :
       {Share{"share of the tape", PositionStep::tape, PositionStep::held},
        {"share of the box's centre", PositionStep::held, PositionStep::box},
        {"share of the alignment to colour", PositionStep::box, PositionStep::aligned},
        {"share of the unit's own calibration", PositionStep::aligned, PositionStep::unit},
        {"share of the stereo noise", PositionStep::unit, PositionStep::measured},
        {"share of the calibration", PositionStep::measured, PositionStep::calibrated},
        {"share of the distortion left out", PositionStep::calibrated, PositionStep::pinhole}})
    add_rows(rows, s.name, unit_name, moved(runs, step(s.from), step(s.to)), seed);
  for (const bool is_straightened : {false, true}) {
    const std::string name =
        is_straightened ? "the paper's lens and its distortion" : "the paper's lens, equation 4";
    std::vector<Moved> all = moved(runs, step(PositionStep::tape), [&](const FruitPosition& p) {
      return by_paper(p, is_straightened);
    });
    add_rows(rows, name, unit_name, all, seed);
    turn_to_fit(all, runs.size());
    add_rows(rows, name + ", axes turned to fit", unit_name, all, seed);
  }
  return rows;
}

std::vector<ScoreRow> published_position_rows() {
  struct Published {
    const char* bin;
    std::array<double, 4> rmse_cm, mae_cm;
  };
  // Section 3.5 and Table 5. The paper gives no number of points in each interval.
  constexpr std::array<Published, 4> kTable = {
      {{"0.3 to 0.6 m", {.21, .23, .30, .31}, {.17, .18, .27, .27}},
       {"0.3 to 0.4 m", {.26, .11, .20, .18}, {.22, .10, .18, .15}},
       {"0.4 to 0.5 m", {.21, .28, .27, .33}, {.18, .22, .25, .30}},
       {"0.5 to 0.6 m", {.13, .24, .39, .35}, {.11, .19, .38, .33}}}};
  std::vector<ScoreRow> rows;
  for (const Published& p : kTable) {
    const std::array<const char*, 4> coordinates = {"x", "y", "z", "range"};
    for (std::size_t c = 0; c < coordinates.size(); ++c) {
      ScoreRow row =
          calibration_row(kScene, std::string("published, ") + p.bin, "the Strawberries paper", 0);
      const std::string name = coordinates[c];
      row.n = std::string(p.bin) == "0.3 to 0.6 m" ? 30 : 0;
      rows.push_back(with_interval(row, name + ".rmse", "m", {0.01 * p.rmse_cm[c]}, row.n));
      rows.push_back(with_interval(row, name + ".mae", "m", {0.01 * p.mae_cm[c]}, row.n));
      rows.push_back(with_interval(row,
                                   name + ".mae over rmse: .80 if normal about 0, 1 if all bias",
                                   "1", {p.mae_cm[c] / p.rmse_cm[c]}, row.n));
    }
  }
  return rows;
}

}  // namespace cousin
