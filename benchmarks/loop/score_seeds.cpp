#include "benchmarks/loop/score_seeds.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include "benchmarks/loop/board_turn.h"
#include "benchmarks/loop/limits.h"
#include "benchmarks/loop/score_geometry.h"
#include "benchmarks/loop/true_outline.h"
#include "benchmarks/loop/truth_stages.h"
#include "benchmarks/score/specimens.h"
#include "benchmarks/score/surface_distance.h"
#include "benchmarks/score/trait_statistics.h"
#include "perception/cloud/measure_traits.h"
#include "sim/geometry/measure.h"
#include "sim/truth/specimens.h"
#include "sim/types/trait_table.h"

namespace cousin {

ScoreRow untrained_row(ScoreRow base, const SplatModel& none) {
  base.metric = "training: " + none.why_none;
  base.unit = "1";
  base.value = ScoreRow::kNone;
  base.status = ScoreStatus::not_solved;
  return base;
}

std::string case_text(const std::string& scene, const ScoreSettings& settings) {
  std::string text = scene + " run " + std::to_string(settings.run) + " " +
                     std::to_string(settings.views) + " views " +
                     std::to_string(settings.width_px) + "x" + std::to_string(settings.height_px);
  if (settings.held_out_every > 0)
    text += ", one in " + std::to_string(settings.held_out_every) + " held out";
  if (!settings.poses.empty()) text += ", poses " + settings.poses;
  if (settings.steps > 0) text += ", " + std::to_string(settings.steps) + " steps";
  return text;
}

ScoreRow labelled_row(const SeedsScoreLabels& labels) {
  ScoreRow row;
  row.suite = labels.suite;
  row.scene = labels.scene;
  row.case_name = labels.case_name;
  row.method = labels.method;
  row.seed = labels.seed;
  static_cast<ScoreSettings&>(row) = labels.settings;
  return row;
}

ScoreRow seconds_row(const SeedsScoreLabels& labels, double wall_s, std::int64_t views) {
  ScoreRow row = labelled_row(labels);
  row.metric = "seconds.measure";
  row.unit = "s";
  row.value = row.wall_s = wall_s;
  row.n = views;
  return row;
}

namespace {

constexpr std::array<double, 3> kTolerances_m = {0.0001, 0.0002, 0.0005};
/// Half a seed: nearer than two seeds lie that are apart. In a heap the next may be nearer.
constexpr double kMatchGate_m = 0.004;
/// The same of larger specimens: half of the thickest one's least size, as who measures what views
/// from above show has its centroid that far up.
double match_gate_m(const std::vector<const Instance*>& specimens) {
  double gate_m = kMatchGate_m;
  for (const Instance* specimen : specimens) {
    double least_m = std::numeric_limits<double>::infinity();
    for (const TrueTrait& trait : specimen->traits) {
      if (trait.name == "length" || trait.name == "width" || trait.name == "height")
        least_m = std::min(least_m, trait.value);
    }
    if (std::isfinite(least_m)) gate_m = std::max(gate_m, 0.5 * least_m);
  }
  return gate_m;
}
constexpr int kSurfaceSamples = 20000;

void add(std::vector<ScoreRow>& rows, const ScoreRow& row, const std::string& metric, double value,
         const std::string& unit, std::int64_t n) {
  rows.push_back(measured_row(row, metric, value, unit, n));
}

/// How many points there are in all, the board's too; those of seeds,
/// and meshes, against all of the true surface, undersides too (`cloud`, `mesh`), and against
/// what two views at least could see of it, posed or not (`cloud_seen`, `mesh_seen`); of clouds
/// that have normals the share with one and their angles to the surface's (`cloud.normal...`).
void score_shapes(const SceneTruth& truth, const std::vector<Mesh>& true_meshes,
                  const Estimate& estimate, const ScoreRow& base, std::vector<ScoreRow>& rows) {
  add(rows, base, "reconstruction.points", static_cast<double>(estimate.cloud.size()), "1", 1);
  if (true_meshes.empty()) return;
  const Mesh surface = merged(true_meshes);
  const std::vector<Eigen::Vector3d> samples = sample_surface(surface, kSurfaceSamples, Rng(1));
  std::vector<Eigen::Vector3d> cloud, normals;
  for (std::size_t i = 0; i < estimate.clusters.cloud.size(); ++i) {
    if (estimate.clusters.instance[i] < 0) continue;
    cloud.push_back(estimate.clusters.cloud[i].position_m.cast<double>());
    normals.push_back(estimate.clusters.cloud[i].normal.cast<double>());
  }
  std::vector<Mesh> measured;
  for (const Surface& s : estimate.surfaces) {
    if (s.status == SurfaceStatus::ok && !s.mesh.triangles.empty()) measured.push_back(s.mesh);
  }
  if (cloud.empty() && measured.empty()) return;
  const VisibleSamples seen = visible_samples(surface, samples, surface_views(truth));
  const auto seen_count = static_cast<std::int64_t>(seen.seen_m.size());
  add(rows, base, "surface.seen",
      static_cast<double>(seen_count) / static_cast<double>(kSurfaceSamples), "1", kSurfaceSamples);
  if (!cloud.empty()) {
    const auto n = static_cast<std::int64_t>(cloud.size());
    add_cloud_rows("cloud", n, score_cloud(cloud, surface, samples, kTolerances_m), base, rows);
    if (seen_count > 0)
      add_cloud_rows("cloud_seen", n, score_visible_cloud(cloud, surface, seen, kTolerances_m),
                     base, rows);
    const NormalScore by_normals = score_normals(cloud, normals, surface);
    if (const std::int64_t count = by_normals.measured; count > 0) {
      add(rows, base, "cloud.normals",
          static_cast<double>(count) / static_cast<double>(by_normals.points), "1",
          by_normals.points);
      add(rows, base, "cloud.normal_median", by_normals.median_rad, "rad", count);
      add(rows, base, "cloud.normal_p95", by_normals.p95_rad, "rad", count);
    }
  }
  if (!measured.empty()) {
    const Mesh all = merged(measured);
    const auto points = sample_surface(all, kSurfaceSamples, Rng(2));
    add_cloud_rows("mesh", kSurfaceSamples,
                   score_mesh(all, points, surface, samples, kTolerances_m), base, rows);
    if (seen_count > 0)
      add_cloud_rows("mesh_seen", kSurfaceSamples,
                     score_visible_mesh(all, points, surface, seen, kTolerances_m), base, rows);
  }
}

/// By how much the objects' convex hulls differ from them: what creases and grooves amount to, and
/// the error of a perfect estimator to which hollows do not show.
void score_hollows(const std::vector<Mesh>& true_meshes, const ScoreRow& base,
                   std::vector<ScoreRow>& rows) {
  if (true_meshes.empty()) return;
  const auto n = static_cast<double>(true_meshes.size());
  double volume = 0, area = 0;
  for (const Mesh& mesh : true_meshes) {
    const MassProperties own = mass_properties(mesh);
    const MassProperties hull = mass_properties(convex_hull(mesh.vertices_m));
    volume += (hull.volume_m3 / own.volume_m3 - 1) / n;
    area += (hull.area_m2 / own.area_m2 - 1) / n;
  }
  const auto count = static_cast<std::int64_t>(true_meshes.size());
  add(rows, base, "true_hull.volume.excess", volume, "1", count);
  add(rows, base, "true_hull.area.excess", area, "1", count);
}

/// Measured outlines against the true apparent contours.
void score_outlines_of(const SceneTruth& truth, const std::vector<Mesh>& true_meshes,
                       const SpecimenMatching& matching, const Estimate& estimate,
                       const ScoreRow& base, std::vector<ScoreRow>& rows) {
  if (estimate.silhouettes.empty()) return;
  std::vector<int> object_of;
  for (const SpecimenMatch& match : matching.matches) {
    const int instance = estimate.traits[static_cast<std::size_t>(match.measured)].instance;
    if (instance < 0) continue;
    object_of.resize(std::max(object_of.size(), static_cast<std::size_t>(instance) + 1), -1);
    object_of[static_cast<std::size_t>(instance)] = match.truth;
  }
  const OutlineScore score =
      score_outlines(estimate.silhouettes, truth.views, true_meshes, object_of);
  if (score.points == 0) return;
  add(rows, base, "outline.bias", score.bias_px, "px", score.points);
  add(rows, base, "outline.rms", score.rms_px, "px", score.points);
  add(rows, base, "outline.rms_over_sigma", score.normalized_rms, "1", score.points);
}

std::vector<Eigen::Vector3d> centroids_of(const Traits& traits) {
  std::vector<Eigen::Vector3d> result;
  for (const SpecimenTraits& t : traits) result.push_back(t.centroid_in_world_m);
  return result;
}

void append_specimen_rows(const Instance& object, const SpecimenTraits* measured,
                          const SeedsScoreLabels& labels, std::vector<SpecimenRow>& rows) {
  for (const TrueTrait& trait : object.traits) {
    if (std::find(kSeedTraits.begin(), kSeedTraits.end(), trait.name) == kSeedTraits.end())
      continue;
    SpecimenRow row;
    row.dataset = labels.suite;
    row.scene = labels.scene;
    row.instance = object.id;
    row.cultivar = variety_of(object);
    row.run = labels.run;
    row.method = labels.method;
    row.trait = trait.name;
    row.unit = trait.unit;
    row.truth = trait.value;
    row.status = ScoreStatus::not_solved;
    if (measured && measured->status == TraitStatus::ok) {
      for (const Trait& m : measured->traits) {
        if (m.name != trait.name) continue;
        if (m.unit != trait.unit) {
          throw std::invalid_argument("traits.json: specimen " +
                                      std::to_string(measured->instance) + ": " + m.name +
                                      " is in " + m.unit + ", and the true one in " + trait.unit);
        }
        row.measured = m.value;
        row.sigma = m.sigma;
        row.status = ScoreStatus::ok;
      }
    }
    rows.push_back(std::move(row));
  }
}

bool in_group(const SpecimenRow& row, const std::string& group) {
  if (group == "all") return row.cultivar != kSphere;
  return row.cultivar == group || species_of(row.cultivar) == group;
}

std::map<std::string, std::string> traits_in(std::span<const SpecimenRow> specimens) {
  std::map<std::string, std::string> units;
  for (const SpecimenRow& row : specimens) units[row.trait] = row.unit;
  return units;
}

}  // namespace

std::vector<std::string> groups_of(std::span<const SpecimenRow> specimens) {
  std::set<std::string> cultivars, species;
  for (const SpecimenRow& row : specimens) {
    cultivars.insert(row.cultivar);
    species.insert(species_of(row.cultivar));
  }
  std::vector<std::string> groups(cultivars.begin(), cultivars.end());
  for (const std::string& s : species) {
    if (!cultivars.contains(s)) groups.push_back(s);
  }
  if (species.size() > (species.contains(kSphere) ? 2U : 1U)) groups.push_back("all");
  return groups;
}

std::string species_of(const std::string& cultivar) {
  static const std::map<std::string, std::string> kSpecies = {
      {"zhengdan958", "maize"}, {"tianguinuo932", "maize"}, {"jimai22", "wheat"},
      {"aikang58", "wheat"},    {"suijing18", "rice"},      {"xiangyaxiangzhan", "rice"}};
  const auto found = kSpecies.find(cultivar);
  return found == kSpecies.end() ? cultivar : found->second;
}

void score_timings(const Estimate& estimate, const ScoreRow& base, std::vector<ScoreRow>& rows) {
  double wall_s = 0, cpu_s = 0, peak_mb = 0, above_mb = ScoreRow::kNone;
  for (const StageTiming& timing : estimate.timings) {
    ScoreRow row = base;
    row.wall_s = timing.wall_s;
    row.cpu_s = timing.cpu_s;
    row.peak_rss_mb = timing.peak_rss_mb;
    row.peak_above_start_mb = timing.peak_above_start_mb;
    add(rows, row, "seconds." + timing.stage, timing.wall_s, "s", 1);
    wall_s += timing.wall_s;
    cpu_s += timing.cpu_s;
    peak_mb = std::max(peak_mb, timing.peak_rss_mb);
    above_mb = std::fmax(above_mb, timing.peak_above_start_mb);  // NaN gives way to a number
  }
  ScoreRow row = base;
  row.wall_s = wall_s;
  row.cpu_s = cpu_s;
  row.peak_rss_mb = peak_mb;
  row.peak_above_start_mb = above_mb;
  add(rows, row, "seconds.perceive", wall_s, "s", 1);
}

SeedsScores score_run(const SceneTruth& truth, const Estimate& as_perceived,
                      const SeedsScoreLabels& labels) {
  const Estimate estimate = turned_to_truth(as_perceived, truth);
  SeedsScores scores;
  const ScoreRow base = labelled_row(labels);
  const auto objects = specimens_of(truth.scene);
  std::vector<Mesh> meshes;
  std::vector<Eigen::Vector3d> true_centroids;
  for (const Instance* object : objects) {
    meshes.push_back(mesh_in_world(truth.scene, *object));
    true_centroids.push_back(mass_properties(meshes.back()).centroid_m);
  }
  const SpecimenMatching matching =
      match_specimens(centroids_of(estimate.traits), true_centroids, match_gate_m(objects));
  std::vector<const SpecimenTraits*> measured(objects.size(), nullptr);
  for (const SpecimenMatch& match : matching.matches) {
    measured[static_cast<std::size_t>(match.truth)] =
        &estimate.traits[static_cast<std::size_t>(match.measured)];
  }
  const auto n = static_cast<std::int64_t>(objects.size());
  add(scores.rows, base, "specimens.found", static_cast<double>(matching.matches.size()), "1", n);
  add(scores.rows, base, "specimens.missed", static_cast<double>(matching.missed.size()), "1", n);
  // What an estimate says it could not measure it does not assert.
  const auto solved = [&](int i) {
    return estimate.traits[static_cast<std::size_t>(i)].status == TraitStatus::ok;
  };
  add(scores.rows, base, "specimens.spurious",
      static_cast<double>(
          std::count_if(matching.spurious.begin(), matching.spurious.end(), solved)),
      "1", n);
  add(scores.rows, base, "specimens.unsolved",
      static_cast<double>(
          std::count_if(estimate.traits.begin(), estimate.traits.end(),
                        [](const SpecimenTraits& t) { return t.status != TraitStatus::ok; })),
      "1", n);
  add_pose_rows(truth, estimate.poses, PoseAlignment::none, base, scores.rows);
  score_outlines_of(truth, meshes, matching, estimate, base, scores.rows);
  score_shapes(truth, meshes, estimate, base, scores.rows);
  score_hollows(meshes, base, scores.rows);
  score_timings(estimate, base, scores.rows);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    append_specimen_rows(*objects[i], measured[i], labels, scores.specimens);
  }
  return scores;
}

std::vector<ScoreRow> pooled_rows(std::span<const SpecimenRow> specimens,
                                  const SeedsScoreLabels& labels) {
  std::vector<ScoreRow> rows;
  std::set<std::string> methods;
  for (const SpecimenRow& row : specimens) methods.insert(row.method);
  for (const std::string& method : methods) {
    for (const std::string& group : groups_of(specimens)) {
      for (const auto& [trait, unit] : traits_in(specimens)) {
        const auto wanted = [&](const SpecimenRow& row) {
          return row.method == method && in_group(row, group);
        };
        const std::vector<TraitPair> pairs = trait_pairs(specimens, trait, wanted);
        ScoreRow base = labelled_row(labels);
        base.case_name = group;
        base.method = method;
        const auto asked = std::count_if(
            specimens.begin(), specimens.end(),
            [&](const SpecimenRow& row) { return row.trait == trait && wanted(row); });
        if (asked == 0) continue;
        add(rows, base, trait + ".solved",
            static_cast<double>(pairs.size()) / static_cast<double>(asked), "1", asked);
        const TraitRow* known = find_trait(trait);
        const bool is_relative = !known || known->scoring == TraitScoring::relative;
        if (pairs.size() == 1) {  // one object, the sphere: its error, without statistics
          add(rows, base, trait + ".bias", pairs[0].measured - pairs[0].truth, unit, 1);
          if (is_relative)
            add(rows, base, trait + ".mape", std::abs(pairs[0].measured / pairs[0].truth - 1), "1",
                1);
        }
        if (pairs.empty()) {
          if (is_relative)
            add_missing(rows, base, trait + ".mape", "1");
          else
            add_missing(rows, base, trait + ".rmse", unit);
        }
        if (pairs.size() < 2) continue;
        const Rng rng = Rng(labels.seed).fork("bootstrap").fork(method + "/" + group + "/" + trait);
        for (ScoreRow& row : score_rows(base, trait, unit, trait_statistics(pairs, rng))) {
          if (is_relative || row.metric != trait + ".mape") rows.push_back(std::move(row));
        }
        const SigmaCoverage coverage = sigma_coverage(pairs);
        if (coverage.n == 0) {
          add_missing(rows, base, trait + ".coverage_95", "1");
          continue;
        }
        for (ScoreRow& row : score_rows(base, trait, coverage)) rows.push_back(std::move(row));
      }
    }
  }
  return rows;
}

std::vector<ScoreRow> paired_rows(std::span<const SpecimenRow> specimens,
                                  const std::string& method_a, const std::string& method_b,
                                  const SeedsScoreLabels& labels) {
  std::vector<ScoreRow> rows;
  for (const std::string& group : groups_of(specimens)) {
    for (const auto& [trait, unit] : traits_in(specimens)) {
      std::map<std::string, PairedMeasurement> pairs;
      std::map<std::string, int> methods_there;
      for (const SpecimenRow& row : specimens) {
        const bool usable =
            row.trait == trait && in_group(row, group) && row.status == ScoreStatus::ok;
        if (!usable || (row.method != method_a && row.method != method_b)) continue;
        const std::string key = row.cultivar + "/" + row.run + "/" + std::to_string(row.instance);
        PairedMeasurement& pair = pairs[key];
        pair.truth = row.truth;
        pair.run = row.run;  // all cultivars of a run share one phone
        (row.method == method_a ? pair.measured_a : pair.measured_b) = row.measured;
        ++methods_there[key];
      }
      std::vector<PairedMeasurement> both;
      for (const auto& [key, pair] : pairs) {
        if (methods_there[key] == 2) both.push_back(pair);
      }
      if (both.size() < 2) continue;
      const Rng rng = Rng(labels.seed).fork("paired").fork(group + "/" + trait);
      const PairedComparison c = compare_paired(both, rng);
      ScoreRow base = labelled_row(labels);
      base.case_name = group;
      base.method = method_a + "/" + method_b;
      rows.push_back(with_interval(base, trait + ".rmse_ratio", "1", c.rmse_ratio, c.n));
      rows.push_back(
          with_interval(base, trait + ".absolute_difference", unit, c.absolute_difference, c.n));
      add(rows, base, trait + ".paired_t", c.t, "1", c.n);
      add(rows, base, trait + ".paired_t_p", c.p_value, "1", c.n);
      const TraitRow* known = find_trait(trait);
      if (known && known->scoring != TraitScoring::relative) continue;  // it may be zero
      std::vector<PairedMeasurement> shares = both;
      for (PairedMeasurement& pair : shares) {
        pair.measured_a /= pair.truth;
        pair.measured_b /= pair.truth;
        pair.truth = 1;
      }
      const PairedComparison relative = compare_paired(shares, rng);
      rows.push_back(with_interval(base, trait + ".relative_difference", "1",
                                   relative.absolute_difference, c.n));
      add(rows, base, trait + ".relative_paired_t", relative.t, "1", c.n);
      add(rows, base, trait + ".relative_paired_t_p", relative.p_value, "1", c.n);
    }
  }
  return rows;
}

Gate parse_gate(const std::string& text) {
  const std::size_t place = text.find("=");
  if (place == std::string::npos || place < 2 ||
      (text[place - 1] != '<' && text[place - 1] != '>')) {
    throw std::invalid_argument("--gate \"" + text + "\" is not 'metric<=x' or 'metric>=x'");
  }
  Gate gate;
  gate.metric = text.substr(0, place - 1);
  gate.at_most = text[place - 1] == '<';
  const char* begin = text.data() + place + 1;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(begin, end, gate.limit);
  if (error != std::errc() || stop != end) {
    throw std::invalid_argument("--gate \"" + text + "\": the limit is no number");
  }
  return gate;
}

std::vector<std::string> broken(const Gate& gate, std::span<const ScoreRow> rows) {
  std::vector<std::string> result;
  bool found = false;
  for (const ScoreRow& row : rows) {
    if (row.metric != gate.metric) continue;
    found = true;
    const bool holds = gate.at_most ? row.value <= gate.limit : row.value >= gate.limit;
    if (!holds) {
      result.push_back(row.case_name + " " + row.method + " " + row.metric + " = " +
                       std::to_string(row.value) + (gate.at_most ? " > " : " < ") +
                       std::to_string(gate.limit));
    }
  }
  if (!found) result.push_back("no row has the metric \"" + gate.metric + "\"");
  return result;
}

}  // namespace cousin
