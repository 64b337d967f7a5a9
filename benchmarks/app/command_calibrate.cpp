// calibrate: images of a target to cameras, with what they are worth.
#include <cstdio>
#include <filesystem>
#include <utility>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/option_keys.h"
#include "benchmarks/app/terminal.h"
#include "benchmarks/loop/result_folder.h"
#include "benchmarks/tools/calibrate/calibration_output.h"
#include "benchmarks/tools/calibrate/calibration_run.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/output_folder.h"
#include "sim/types/not_built.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

CalibrateConfig config_of(const Options& o) {
  CalibrateConfig config;
  config.calibration.solver = default_calibration_solver();
  if (!o.config.empty()) read_toml(o.config, fields(config), MissingKeys::keep_default);
  if (!o.model.empty()) config.model = lens_model_from_string(o.model);
  if (!o.solver.empty()) config.calibration.solver = calibration_solver_from_string(o.solver);
  // The others weigh all points alike.
  if (config.calibration.solver != CalibrationSolver::ceres)
    config.calibration.weigh_by_covariance = false;
  if (!o.fixed.empty()) set_field(fields(config), "calibration.fixed=" + o.fixed);
  for (const std::string& set : o.sets) set_field(fields(config), set);
  validate(config);
  return config;
}

/// @throws NotBuilt
void require_solver(CalibrationSolver solver) {
  const bool is_there = solver == CalibrationSolver::mrcal   ? COUSIN_WITH_MRCAL != 0
                        : solver == CalibrationSolver::ceres ? COUSIN_WITH_CERES != 0
                                                             : true;
  if (is_there) return;
  const std::string name(to_string(solver));
  throw NotBuilt("solver " + name + " is not in this build (" +
                 (solver == CalibrationSolver::mrcal ? "`scripts/build mrcal` builds it"
                                                     : "CMake: WITH_CERES=ON") +
                 "); --solver opencv is there");
}

bool is_dataset(const fs::path& folder) {
  return fs::is_directory(folder) && !scene_folders(folder).empty();
}

}  // namespace

ExitCode command_calibrate(const JobContext& context) {
  const Options& o = context.options;
  const CalibrateConfig config =
      read_config(o, {{"--fix", "calibration.fixed", o.fixed}}, [&] { return config_of(o); });
  if (o.keys) {
    CalibrateConfig defaults = config;
    std::printf("%s", describe(fields(defaults)).c_str());
    return ExitCode::done;
  }
  require_solver(config.calibration.solver);
  const fs::path source = o.arguments.at(0);
  if (!fs::is_directory(source)) throw std::runtime_error(source.string() + ": not a folder");
  const bool dataset = is_dataset(source);
  if (!dataset && o.board.empty())
    throw std::invalid_argument(source.string() +
                                ": a folder of photographs needs --board, such as "
                                "chessboard:6x4:0.030");
  CalibrationPhotos photos = dataset ? photos_of_dataset(source, o.board)
                                     : photos_of_folder(source, target_from_option(o.board));
  photos.layout = layout_from_option(o.board);
  const fs::path out = o.out.empty() ? fs::path("out") / "calibrate" : fs::path(o.out);
  require_writable(out);
  std::vector<std::string> names = calibration_names();
  names.emplace_back("report.html");
  OutputFolder folder(out, {.verb = "calibrate",
                            .version = COUSIN_VERSION,
                            .config = {},
                            .names = result_names(std::move(names))});
  const CalibrationRun run =
      run_calibration(std::move(photos), config, context.progress.function());

  ScoreFile scores;
  if (o.solver.empty() && config.calibration.solver != CalibrationSolver::ceres)
    context.progress.line("built without Ceres: solved by " +
                          std::string(to_string(config.calibration.solver)));
  scores.scores = calibration_rows(run);
  scores.header.program_version = COUSIN_VERSION;
  scores.header.machine = machine_text();
  scores.header.more["command"] = context.command_line;
  const std::string json = calibration_json(run);
  write_result_tables(out, scores);
  write_file(out / "calibration.json", json);
  const std::vector<std::string> written = write_calibration_files(out, run);
  write_calibration_report(out / "report.html", run, scores, context.command_line);
  folder.remove_earlier();
  if (o.json)
    std::printf("%s", json.c_str());
  else
    print_result_lines(calibration_table(run));
  for (const std::string& line : written) context.progress.line(line);
  context.progress.line("report: " + (out / "report.html").string());
  return run.problems.empty() ? ExitCode::done : ExitCode::gate_failed;
}

}  // namespace cousin
