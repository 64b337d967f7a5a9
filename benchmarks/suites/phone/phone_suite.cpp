#include "benchmarks/suites/phone/phone_suite.h"

#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include "benchmarks/loop/perceive.h"
#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/loop/seeds_run.h"
#include "benchmarks/loop/simulate.h"
#include "benchmarks/tools/measure/board_lens.h"
#include "benchmarks/tools/measure/sample_source.h"
#include "sim/imaging/image_io.h"
#include "sim/process/program_run.h"
#include "sim/process/scratch_folder.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSuite = "phone";
constexpr int kRuns = 2;
constexpr double kMostRatio = 1.5;

/// How pictures are taken and kept.
struct Way {
  const char* name;
  bool is_blind = false;
  int pictures_per_s = 0;  ///< of the video; 0 = none
  double sag_m = 0;
};
constexpr Way kWays[] = {{"calibrated"},
                         {"blind", true},
                         {"video", true, 10},
                         {"video_30", true, 30},
                         {"sheet", true, 10, 0.0005}};

Factor ways() {
  Factor factor{"way", {}};
  for (const Way& way : kWays) {
    Level level{way.name};
    char sag[48];
    std::snprintf(sag, sizeof sag, "sheet_sag_m=%g", way.sag_m);
    level.sets = {sag};
    factor.levels.push_back(std::move(level));
  }
  return factor;
}

Grid phone_grid(const PhoneSuiteConfig& config) {
  if (config.quick) {
    return {{"quick_{cultivar}_{way}",
             {key_factor("cultivar", {"zhengdan958"}), key_factor("views", {"30"}),
              key_factor("seeds", {"6"}), ways()}}};
  }
  return {{"{cultivar}_{way}_run{run}",
           {number_factor("run", 0, config.runs > 0 ? config.runs : kRuns),
            key_factor("cultivar", {"zhengdan958", "jimai22", "suijing18"}), ways()}}};
}

/// "000012.png", as ffmpeg counts them.
std::string picture_name(std::size_t i) {
  char name[32];
  std::snprintf(name, sizeof name, "%06zu.png", i);
  return name;
}

/// The first sensor's pictures as a video. @throws std::runtime_error saying what ffmpeg says
void encode(const Capture& capture, int pictures_per_s, const fs::path& folder,
            const fs::path& video) {
  for (std::size_t i = 0; i < capture.frames.size(); ++i) {
    write_png(folder / picture_name(i), capture.frames[i].sensors.front().color);
  }
  ProgramCall call;
  call.words = {"ffmpeg",
                "-v",
                "error",
                "-nostdin",
                "-y",
                "-framerate",
                std::to_string(pictures_per_s),
                "-i",
                (folder / "%06d.png").string(),
                "-c:v",
                "libx264",
                "-b:v",
                "8M",
                "-maxrate",
                "8M",
                "-bufsize",
                "8M",
                "-threads",
                "1",
                "-pix_fmt",
                "yuv420p",
                video.string()};
  call.log = folder / "log";
  call.time_limit_s = 1800;
  const ProgramOutcome outcome = run_program(call);
  if (!succeeded(outcome))
    throw std::runtime_error("ffmpeg: " + outcome.reason + last_lines(call.log));
}

/// What the phone's user has of a simulated capture.
Capture as_taken(const Capture& simulated, const Way& way) {
  const ScratchFolder scratch("cousin_phone");
  const fs::path pictures = scratch.path() / "pictures";
  fs::create_directories(pictures);
  const int count = static_cast<int>(simulated.frames.size());
  if (way.pictures_per_s > 0) {
    const fs::path video = scratch.path() / "seeds.mp4";
    encode(simulated, way.pictures_per_s, pictures, video);
    return read_sample({"seeds", "seeds", video, SamplePlace::Kind::video}, {.frames = count});
  }
  for (std::size_t i = 0; i < simulated.frames.size(); ++i)
    write_png(pictures / picture_name(i), simulated.frames[i].sensors.front().color);
  return read_sample({"seeds", "seeds", pictures, SamplePlace::Kind::photographs}, {});
}

ScoreFile run_job(const PhoneSuiteConfig& suite, const GridJob& job) {
  const Way& way = kWays[job.at("way").level];
  std::vector<std::string> sets = job.sets;
  sets.insert(sets.end(), suite.sets.begin(), suite.sets.end());
  const RunConfig config = seeds_run_config(sets);
  const int run = job.has("run") ? job.number("run") : 0;
  const SimulatedRun simulated = simulate(config, suite.seed, run, {});
  SeedsPipelineConfig pipeline = seeds_pipeline(config);
  const StageClock clock("measure");
  Capture capture;
  if (way.is_blind) {
    capture = as_taken(simulated.capture, way);
    trust_the_board(pipeline);
    (void)take_lens_of_board(pipeline, capture);
  }
  const Estimate estimate =
      perceive(way.is_blind ? capture : simulated.capture, pipeline, suite.seed, {}, 0, {});
  const double wall_s = clock.finish().wall_s;
  SeedsScoreLabels labels;
  labels.suite = kSuite;
  labels.scene = job.at("cultivar").word;
  labels.case_name = job.at("cultivar").word;
  labels.method = way.name;
  labels.run = "run" + std::to_string(run);
  labels.seed = suite.seed;
  labels.settings.views = config.scene.views();
  SeedsScores scores = score_run(simulated.truth, estimate, labels);
  ScoreFile file;
  file.scores = std::move(scores.rows);
  file.specimens = std::move(scores.specimens);
  file.scores.push_back(seconds_row(labels, wall_s, config.scene.views()));
  return file;
}

}  // namespace

std::vector<ShardJob> phone_suite_jobs(const PhoneSuiteConfig& config) {
  return shards_of(
      phone_grid(config), std::string(COUSIN_VERSION) + "/phone/" + std::to_string(config.seed),
      config.sets, [config](const GridJob& job) { return to_json(run_job(config, job)); });
}

std::vector<ScoreRow> phone_pooled_rows(const std::vector<SpecimenRow>& specimens,
                                        std::uint64_t seed) {
  SeedsScoreLabels labels;
  labels.suite = kSuite;
  labels.scene = "pooled";
  labels.seed = seed;
  std::vector<ScoreRow> rows = pooled_rows(specimens, labels);
  for (const Way& way : kWays) {
    if (!way.is_blind) continue;
    const bool is_held = std::string_view(way.name) == "video" || way.sag_m > 0;
    for (ScoreRow& row : paired_rows(specimens, way.name, kWays[0].name, labels)) {
      const bool is_ratio = row.metric.ends_with("rmse_ratio") && row.case_name == "all";
      rows.push_back(is_held && is_ratio ? limited(row, at_most(kMostRatio)) : row);
    }
  }
  return rows;
}

}  // namespace cousin
