#include "benchmarks/suites/plants/plants_suite.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>

#include "benchmarks/score/distributions.h"
#include "benchmarks/suites/plants/berry_rows.h"
#include "benchmarks/suites/plants/orchard_rows.h"
#include "scenes/apples/apple.h"
#include "scenes/strawberries/truss.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

constexpr int kDraws = 2000;

ScoreRow base_row(const std::string& scene, const std::string& case_name, std::uint64_t seed) {
  ScoreRow row;
  row.suite = "plants";
  row.scene = scene;
  row.case_name = case_name;
  row.method = "ours";
  row.seed = seed;
  row.unit = "1";
  return row;
}

/// Mean and spread of a drawn quantity.
struct Drawn {
  double mean = 0;
  double sigma = 0;
};

Drawn draw_many(const std::function<double(Rng)>& draw, const Rng& rng) {
  double sum = 0;
  double squares = 0;
  for (std::uint64_t i = 0; i < kDraws; ++i) {
    const double x = draw(rng.fork(i));
    sum += x;
    squares += x * x;
  }
  const double mean = sum / kDraws;
  return {mean, std::sqrt(squares / kDraws - mean * mean)};
}

/// A mean beside the published one: passes if that lies in the 95 % interval of the mean drawn.
ScoreRow published_mean(ScoreRow row, const std::string& metric, const std::string& unit,
                        const Drawn& drawn, double published) {
  row.metric = metric;
  row.unit = unit;
  row.value = drawn.mean;
  row.n = kDraws;
  const double half = kSigmas95 * drawn.sigma / std::sqrt(static_cast<double>(kDraws));
  row.ci_low = drawn.mean - half;
  row.ci_high = drawn.mean + half;
  return limited(row, about(published, half));
}

/// A value that the source gives as a range.
ScoreRow published_range(ScoreRow row, const std::string& metric, double value, double low,
                         double high) {
  row.metric = metric;
  row.value = value;
  row.n = kDraws;
  return limited(row, between(low, high));
}

void size_rows(std::vector<ScoreRow>& rows, std::uint64_t seed) {
  const Rng rng = Rng(seed).fork("sizes");
  const AppleCultivar& fuji = apple_cultivar("fuji");
  const ScoreRow apple = base_row("apples", "fuji", seed);
  const auto size = [](const auto& kind) {
    return [&kind](Rng one) { return draw_size(kind, one); };
  };
  const auto apple_size = size(fuji);
  const Drawn mass = draw_many([&](Rng r) { return apple_size(r).mass_kg; }, rng);
  rows.push_back(
      published_mean(apple, "mass (0.245: KJFP 21(5), 618, 2014, table 1)", "kg", mass, 0.245));
  rows.push_back(published_range(apple, "mass.cv (0.16..0.28: Zhang & Robson)",
                                 mass.sigma / mass.mean, 0.16, 0.28));
  const Drawn volume = draw_many([&](Rng r) { return 1e3 / apple_size(r).density_kg_m3; }, rng);
  rows.push_back(published_range(apple, "litres a kg (1.13..1.18: KJFP 2014, six size classes)",
                                 volume.mean, 1.13, 1.18));
  const StrawberryVariety& akihime = strawberry_variety("akihime");
  const auto berry_size = size(akihime);
  rows.push_back(published_mean(
      base_row("strawberries", "akihime", seed), "mass (0.020: description of the variety Zhangji)",
      "kg", draw_many([&](Rng r) { return berry_size(r).mass_kg; }, rng), 0.020));
  for (const std::string& name : strawberry_varieties()) {
    rows.push_back(published_range(base_row("strawberries", name, seed),
                                   "achenes (150..300: Darrow, The Strawberry, 1966)",
                                   strawberry_variety(name).achenes, 150, 300));
  }
}

/// Trusses of 1 to 10 fruits, as the paper's images have them, ripe as drawn: shares of the three
/// classes of maturity beside its 4776, 2452 and 1399 fruits.
void maturity_rows(std::vector<ScoreRow>& rows, std::uint64_t seed) {
  const Rng rng = Rng(seed).fork("maturity");
  std::array<std::int64_t, 3> counts{};
  for (std::uint64_t i = 0; i < kDraws; ++i) {
    const Rng one = rng.fork(i);
    Rng count = one.fork("count");
    const int fruits = 1 + static_cast<int>(uniform_index(count, 10));
    TrussConfig config;
    config.fruits = fruits;
    for (const double red : asked_red_shares(config, one))
      ++counts[red < 0.3 ? 0 : (red <= 0.8 ? 1 : 2)];
  }
  const std::int64_t all = counts[0] + counts[1] + counts[2];
  constexpr std::array<const char*, 3> kNames = {"low (red share below 0.3)", "medium", "high"};
  constexpr std::array<double, 3> kPaper = {4776.0 / 8627, 2452.0 / 8627, 1399.0 / 8627};
  for (std::size_t k = 0; k < 3; ++k) {
    ScoreRow row = base_row("strawberries", "maturity", seed);
    char metric[80];
    std::snprintf(metric, sizeof metric, "share of %s (%.3f +- 0.05: Strawberries 2.1)", kNames[k],
                  kPaper[k]);
    row.metric = metric;
    row.n = all;
    row.value = static_cast<double>(counts[k]) / static_cast<double>(all);
    rows.push_back(limited(row, about(kPaper[k], 0.05)));
  }
}

void built_rows(std::vector<ScoreRow>& rows, std::uint64_t seed, int count) {
  const Rng rng = Rng(seed).fork("built");
  ScoreRow berry = base_row("strawberries", "one fruit", seed);
  ScoreRow apple = base_row("apples", "one fruit", seed);
  berry.n = apple.n = count;
  double off = 0;
  const StageClock berries("strawberries");
  for (int i = 0; i < count; ++i) {
    StrawberryConfig config;
    const auto varieties = strawberry_varieties();
    config.variety = varieties[static_cast<std::size_t>(i) % varieties.size()];
    config.red_share = static_cast<double>(i) / count;
    const FruitModel fruit = make_strawberry(config, rng.fork(static_cast<std::uint64_t>(i)));
    off = std::max(off, std::abs(trait(fruit, "red_share") - config.red_share));
  }
  const StageTiming berry_time = berries.finish();
  berry.metric = "red share, largest off what was asked (at most 0.005)";
  berry.value = off;
  rows.push_back(limited(berry, at_most(0.005)));
  berry.metric = "seconds";
  berry.unit = "s";
  berry.value = berry.wall_s = berry_time.wall_s / count;
  berry.cpu_s = berry_time.cpu_s / count;
  rows.push_back(berry);
  const StageClock apples("apples");
  for (int i = 0; i < count; ++i) make_apple({}, rng.fork(static_cast<std::uint64_t>(i)));
  const StageTiming apple_time = apples.finish();
  apple.metric = "seconds";
  apple.unit = "s";
  apple.value = apple.wall_s = apple_time.wall_s / count;
  apple.cpu_s = apple_time.cpu_s / count;
  rows.push_back(apple);
}

void truss_rows(std::vector<ScoreRow>& rows, std::uint64_t seed, int fruits) {
  TrussConfig config;
  config.fruits = fruits;
  config.ripeness = 1.2;
  ScoreRow row = base_row("strawberries", "truss of " + std::to_string(fruits), seed);
  const StageClock clock("truss");
  const Truss truss = make_truss(config, Rng(seed).fork("truss"));
  const StageTiming time = clock.finish();
  row.n = fruits;
  if (truss.status == PlantStatus::not_built) {
    row.metric = "not built in: MuJoCo (WITH_MUJOCO=OFF)";
    row.status = ScoreStatus::not_built;
    rows.push_back(row);
    return;
  }
  row.metric = "comes to rest, status " + std::string(to_string(truss.status));
  row.value = truss.status == PlantStatus::ok ? 1 : 0;
  rows.push_back(limited(row, at_least(1)));
  row.metric = "deepest overlap of fruits, stalks and bed (at most 0.0005)";
  row.unit = "m";
  row.value = truss.sag.max_penetration_m;
  rows.push_back(limited(row, at_most(5e-4)));
  row.metric = "largest stress over strength";
  row.unit = "1";
  row.value = truss.sag.strain.ratio;
  row.status = ScoreStatus::ok;
  rows.push_back(row);
  row.metric = "seconds, building and settling";
  row.unit = "s";
  row.value = row.wall_s = time.wall_s;
  row.cpu_s = time.cpu_s;
  rows.push_back(row);
}

}  // namespace

ScoreFile plants_suite(std::uint64_t seed, bool quick, const Progress& progress) {
  ScoreFile file;
  const std::vector<int> trusses = quick ? std::vector{1, 5} : std::vector{1, 3, 5, 8, 12};
  const int steps = 4 + static_cast<int>(trusses.size());
  int done = 0;
  const auto tell = [&](const std::string& what) {
    if (progress) progress(what, done, steps);
    ++done;
  };
  tell("sizes");
  size_rows(file.scores, seed);
  maturity_rows(file.scores, seed);
  tell("fruits");
  built_rows(file.scores, seed, quick ? 3 : 12);
  for (const int fruits : trusses) {
    tell("truss of " + std::to_string(fruits));
    truss_rows(file.scores, seed, fruits);
  }
  tell("stretch of strawberries");
  const std::vector<ScoreRow> berries = berry_rows(seed, quick);
  file.scores.insert(file.scores.end(), berries.begin(), berries.end());
  tell("apple tree");
  const std::vector<ScoreRow> orchard = orchard_rows(seed, quick);
  file.scores.insert(file.scores.end(), orchard.begin(), orchard.end());
  return file;
}

}  // namespace cousin
