#include "tests/benchmarks/report/example_report.h"

#include <cmath>
#include <numbers>

#include "sim/types/rng.h"

namespace cousin {
namespace {

/// One red pixel.
std::vector<std::uint8_t> tiny_png() {
  return {0x89, 'P',  'N',  'G',  0x0d, 0x0a, 0x1a, 0x0a, 0,    0,    0,    0x0d, 'I',  'H',
          'D',  'R',  0,    0,    0,    1,    0,    0,    0,    1,    8,    2,    0,    0,
          0,    0x90, 0x77, 0x53, 0xde, 0,    0,    0,    0x0c, 'I',  'D',  'A',  'T',  0x08,
          0xd7, 0x63, 0xf8, 0xcf, 0xc0, 0,    0,    0x03, 0x01, 0x01, 0,    0x18, 0xdd, 0x8d,
          0xb0, 0,    0,    0,    0,    'I',  'E',  'N',  'D',  0xae, 0x42, 0x60, 0x82};
}

void add_specimens(ReportInput& input, Rng rng) {
  const struct {
    const char* name;
    const char* unit;
    double mean, spread, error;
  } traits[] = {{"length", "m", 0.0115, 0.0006, 0.00008},
                {"width", "m", 0.0085, 0.0005, 0.00007},
                {"height", "m", 0.0045, 0.0004, 0.00010},
                {"volume", "m3", 2.3e-7, 2e-8, 6e-9}};
  for (int instance = 0; instance < 50; ++instance) {
    for (const auto& trait : traits) {
      const double truth = trait.mean + trait.spread * normal(rng);
      for (const char* method : {"ours", "paper"}) {
        const bool ours = std::string_view(method) == "ours";
        SpecimenRow row;
        row.dataset = "example";
        row.scene = "seeds";
        row.instance = instance % 10;
        row.cultivar = instance % 20 < 10 ? "zhengdan958" : "tianguinuo932";
        row.run = "run " + std::to_string(instance / 10);
        row.method = method;
        row.trait = trait.name;
        row.unit = trait.unit;
        row.truth = truth;
        row.sigma = ours ? trait.error : ScoreRow::kNone;
        row.measured =
            truth + (ours ? 1.0 : 3.0) * trait.error * normal(rng) + (ours ? 0 : trait.error);
        if (instance == 7 && !ours) {
          row.status = ScoreStatus::not_solved;
          row.measured = ScoreRow::kNone;
        }
        input.scores.specimens.push_back(row);
      }
    }
  }
  for (const auto& trait : traits) {
    for (const char* method : {"ours", "paper"}) {
      ScoreRow row;
      row.suite = "seeds";
      row.scene = "zhengdan958";
      row.case_name = "60 views";
      row.method = method;
      row.seed = 1;
      row.wall_s = 141.2;
      row.peak_rss_mb = 1322;
      const auto pairs =
          trait_pairs(std::span<const SpecimenRow>(input.scores.specimens), trait.name,
                      [&](const SpecimenRow& r) { return r.method == method; });
      const auto statistics =
          score_rows(row, trait.name, trait.unit, trait_statistics(pairs, Rng(1)));
      input.scores.scores.insert(input.scores.scores.end(), statistics.begin(), statistics.end());
    }
  }
}

ReportShape ellipsoid(bool mesh) {
  ReportShape shape{mesh ? "fitted surface" : "cloud",
                    mesh ? "A closed surface." : "Points with colours.",
                    {},
                    {},
                    {}};
  constexpr int kAround = 96;
  constexpr int kUp = 48;
  for (int j = 0; j <= kUp; ++j) {
    for (int i = 0; i < kAround; ++i) {
      const double phi = 2 * std::numbers::pi * i / kAround;
      const double theta = std::numbers::pi * j / kUp;
      shape.positions_m.push_back(Eigen::Vector3d(0.006 * std::sin(theta) * std::cos(phi),
                                                  0.004 * std::sin(theta) * std::sin(phi),
                                                  0.0025 * std::cos(theta))
                                      .cast<float>());
      shape.colors.push_back({static_cast<std::uint8_t>(200 - j),
                              static_cast<std::uint8_t>(150 + 20 * (i / 8 % 2)), 60});
      if (!mesh || j == kUp) continue;
      const auto a = static_cast<std::uint32_t>(j * kAround + i);
      const auto b = static_cast<std::uint32_t>(j * kAround + (i + 1) % kAround);
      shape.triangles.push_back({a, a + kAround, b});
      shape.triangles.push_back({b, a + kAround, b + kAround});
    }
  }
  return shape;
}

/// Discs over the ellipsoid's points, as a trained model has them.
ReportShape gaussians() {
  ReportShape shape = ellipsoid(false);
  shape.name = "Gaussians";
  for (const Eigen::Vector3f& p : shape.positions_m) {
    const Eigen::Quaternionf turn =
        Eigen::Quaternionf::FromTwoVectors(Eigen::Vector3f::UnitZ(), p.normalized());
    shape.splats.push_back({{2e-4F, 3e-4F, 2e-5F}, turn, 0.8F});
  }
  return shape;
}

}  // namespace

ReportInput example_report() {
  ReportInput input;
  input.title = "Seeds: example <report> & \"quotes\"";
  input.summary = "Made-up numbers that fill every section.";
  input.commands = {"cousin run seeds --seed 1 --out out/seeds",
                    "cousin report out/seeds  # </script><b>not markup</b>"};
  input.config_toml = "[scene]\ncultivar = \"zhengdan958\"\nviews = 60\n";
  input.scores.header = {"0.1.0", "3f1c", "99ab", "2 cores", {{"compiler", "gcc 12.2"}}};
  add_specimens(input, Rng(4));
  input.plotted = input.scores.specimens;
  input.headlines = {
      {"RMSE of length", {0.000081, 0.000069, 0.000094}, "m", "at most 0.15 mm", ScoreStatus::pass},
      {"RMSE of height", {0.00017, 0.00014, 0.00021}, "m", "at most 0.15 mm", ScoreStatus::fail},
      {"volume, MAPE", {0.021, 0.017, 0.026}, "%", "at most 5 %", ScoreStatus::pass},
      {"wall time", {.value = 141.2}, "s", "at most 240 s", ScoreStatus::pass}};
  const auto limit = [&](const std::string& label, const std::string& group, double value,
                         const std::string& text, ScoreStatus status) {
    Headline h{label, {value}, "m", text, status};
    h.group = group;
    input.limits.push_back(h);
  };
  limit("length.rmse", "maize", 0.00008, "at most 0.15 mm", ScoreStatus::pass);
  limit("length.bias", "maize", -0.00001, "within 0.03 mm", ScoreStatus::pass);
  limit("length.rmse", "wheat", 0.00006, "at most 0.08 mm", ScoreStatus::pass);
  limit("length.bias", "wheat", 0.00005, "within 0.03 mm", ScoreStatus::fail);
  input.images = {{"view 0", "The first view.", tiny_png()}};
  input.shapes = {ellipsoid(false), ellipsoid(true), gaussians()};
  ErrorTimeCurve curve{"Views and image size", "RMSE of length", "m", {}};
  for (const int views : {10, 20, 60, 120, 270}) {
    const double error = 0.0006 / std::sqrt(views) + 0.00003;
    curve.points.push_back({"ours",
                            std::to_string(views) + " views",
                            2.1 * views,
                            {error, 0.8 * error, 1.25 * error}});
    curve.points.push_back({"paper",
                            std::to_string(views) + " views",
                            1.7 * views,
                            {2.4 * error, 2 * error, 3 * error}});
  }
  input.curves = {curve};
  Distribution lengths{"Lengths", "length", "m", {}};
  Rng spread(5);
  for (const char* name : {"photograph 1", "photograph 2", "suijing18"}) {
    DistributionGroup group{name, std::string(name) == "suijing18" ? "scene" : "real", {}};
    for (int i = 0; i < 150; ++i) group.values.push_back(0.0075 + 0.0003 * normal(spread));
    lengths.groups.push_back(std::move(group));
  }
  input.distributions = {lengths};
  input.lines = {{"Noise over distance",
                  {"Both axes logarithmic; one point has no place on them."},
                  "distance (m)",
                  "noise (mm)",
                  true,
                  true,
                  {{"measured", {{0.5, {1, 0.9, 1.1}}, {1, {4, 3.8, 4.2}}, {2, {0}}}, false, false},
                   {"law", {{0.5, {1}}, {2, {16}}}, true}}}};
  input.attributions = {{"Length",
                         "RMSE of length",
                         "m",
                         {{"as it is", {0.000081, 0.000069, 0.000094}},
                          {"corners", {0.000074, 0.000063, 0.000086}},
                          {"poses", {0.000055, 0.000047, 0.000064}},
                          {"depth", {0.000021, 0.000017, 0.000026}},
                          {"masks", {0.000024, 0.000019, 0.00003}}}}};
  input.timings = {{"corners", 2.1, 3.9, 300},
                   {"poses", 0.4, 0.4, 310},
                   {"depth", 61.5, 118, 900},
                   {"surfaces", 22.7, 44, 1000}};
  input.notes = {"2 of 60 views could not be posed: the board was not seen."};
  return input;
}

}  // namespace cousin
