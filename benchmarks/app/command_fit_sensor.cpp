// fit-sensor: a user's recordings of a camera to a preset.
#include <cstdio>
#include <filesystem>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/option_keys.h"
#include "benchmarks/app/terminal.h"
#include "benchmarks/loop/result_folder.h"
#include "benchmarks/tools/fit_sensor/fit_report.h"
#include "benchmarks/tools/fit_sensor/fit_rows.h"
#include "benchmarks/tools/fit_sensor/sensor_fit.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/output_folder.h"

namespace cousin {
namespace fs = std::filesystem;

ExitCode command_fit_sensor(const JobContext& context) {
  const Options& o = context.options;
  const RigChoice rig = read_config(o, {}, [&] { return rig_choice(o.rig); });
  const Recordings recordings = read_recordings(o.arguments.at(0));
  const fs::path out = o.out.empty() ? fs::path("out") / "fit_sensor" : fs::path(o.out);
  require_writable(out);
  OutputFolder folder(out, {.verb = "fit-sensor",
                            .version = COUSIN_VERSION,
                            .config = {},
                            .names = result_names({"report.html", "preset.toml"})});
  const SensorFit fit = fit_sensor(recordings, rig, context.progress.function());

  ScoreFile scores = fit_rows(fit);
  scores.header.program_version = COUSIN_VERSION;
  scores.header.machine = machine_text();
  scores.header.more["command"] = context.command_line;
  write_result_tables(out, scores);
  write_fit_report(out / "report.html", fit, scores, context.command_line);
  const fs::path preset = out / "preset.toml";
  if (!fit.preset_toml.empty()) write_file(preset, fit.preset_toml);
  folder.remove_earlier();  // the preset too, where this fit has none
  if (o.json)
    std::printf("%s", to_json(scores).c_str());
  else
    print_result_lines(fit_table(fit));
  if (!fit.preset_toml.empty()) context.progress.line("preset: " + preset.string());
  context.progress.line("report: " + (out / "report.html").string());
  return fit.problems.empty() ? ExitCode::done : ExitCode::gate_failed;
}

}  // namespace cousin
