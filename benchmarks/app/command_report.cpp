// report: makes a page anew from the tables in its folder, or an index of folders of results.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/app/suite_plots.h"
#include "benchmarks/loop/result_folder.h"
#include "benchmarks/loop/results_index.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/output_folder.h"
#include "sim/types/whole_file.h"

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

/// README.md and its plot, of a folder of folders of results.
ExitCode index_of_results(const JobContext& context, const fs::path& folder) {
  const std::vector<KeptResults> results = kept_results(folder);
  if (results.empty())
    throw std::runtime_error(folder.string() +
                             ": holds no scores.json, and no folder with scores.csv");
  const fs::path out = context.options.out.empty() ? folder : fs::path(context.options.out);
  // The folder is a person's, and stays as it is beside these: what they replace is an index too.
  const auto put = [&](const char* name, const std::string& text) {
    const fs::path file = out / name;
    const std::string begin = text.substr(0, text.find('\n'));
    if (fs::exists(file) && !read_file(file).starts_with(begin.substr(0, 14)))
      throw std::invalid_argument(file.string() +
                                  " is in the way: it is no index that `cousin report` wrote");
    write_file(file, text);
  };
  put("README.md", results_index(results));
  put("limits.svg", results_plot(results));
  if (context.options.json) print_json({{"index", (out / "README.md").string()}});
  context.progress.line("index: " + (out / "README.md").string());
  return ExitCode::done;
}

}  // namespace

ExitCode command_report(const JobContext& context) {
  const fs::path folder = context.options.arguments.at(0);
  if (fs::is_directory(folder) && !fs::exists(folder / "scores.json"))
    return index_of_results(context, folder);
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
