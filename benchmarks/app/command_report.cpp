// report: makes a page anew from the tables in its folder.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/app/suite_plots.h"
#include "benchmarks/loop/result_folder.h"
#include "sim/dataset/output_folder.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

/// The page belongs to the command that wrote it, or to `report` where it is new.
OutputFolder page_folder(const fs::path& folder) {
  const std::string owner = owner_of(folder, "report.html");
  return {folder,
          {.verb = owner.empty() ? "report" : owner,
           .version = COUSIN_VERSION,
           .config = {},
           .names = {"report.html"}}};
}

}  // namespace

ExitCode command_report(const JobContext& context) {
  const fs::path folder = context.options.arguments.at(0);
  SeedsReport report = read_report_folder(folder);
  require_plots(report);
  if (context.options.out.empty() && report.title == kRealTitle) {
    throw std::invalid_argument(folder.string() +
                                ": the page of `bench real` shows pictures that only that command "
                                "makes; give --out to have its tables alone on another page");
  }
  const fs::path file = context.options.out.empty() ? folder / "report.html"
                                                    : fs::path(context.options.out) / "report.html";
  const OutputFolder guard = page_folder(file.parent_path());
  try {
    add_plots(report);
    write_report(file, report);
  } catch (const std::invalid_argument& error) {  // of what scores.json holds
    throw std::runtime_error((folder / "scores.json").string() + ": " + error.what());
  }
  if (context.options.json) {
    print_json({{"report", file.string()}});
  }
  context.progress.line("report: " + file.string());
  return ExitCode::done;
}

}  // namespace cousin
