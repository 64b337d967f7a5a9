// board: a calibration target, or the seed board, as pages to print.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/tools/calibrate/calibration_photos.h"
#include "benchmarks/tools/print_board/board_page.h"
#include "sim/dataset/atomic_file.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

/// @throws std::invalid_argument where another file than a page of ours would be lost
void require_own(const fs::path& file, const std::string& extension) {
  if (!fs::exists(fs::symlink_status(file))) return;
  constexpr std::size_t kLimit_bytes = std::size_t{64} << 20;
  const bool is_ours = fs::is_regular_file(fs::symlink_status(file)) &&
                       is_page_file(read_file(file, kLimit_bytes), extension);
  if (!is_ours)
    throw std::invalid_argument("--out " + file.string() +
                                " is there, and is no page that `cousin board` wrote");
}

}  // namespace

ExitCode command_board(const JobContext& context) {
  const Options& o = context.options;
  const std::string& name = o.arguments.at(0);
  const CalibrationTarget target = target_from_option(name);
  std::string file_name = name;
  for (char& c : file_name) {
    if (c == ':' || c == '/') c = '_';
  }
  const fs::path file =
      o.out.empty() ? fs::path("out") / ("board_" + file_name + ".pdf") : fs::path(o.out);
  const std::string extension = file.extension().string();
  if (extension != ".pdf" && extension != ".svg")
    throw std::invalid_argument("--out " + file.string() + ": its name must end with .pdf or .svg");
  const BoardPage board = board_page(target, name, o.paper);
  std::vector<PrintPage> pages = {board.page};
  if (extension == ".pdf") {
    for (PrintPage& page : protocol_pages(target, board)) pages.push_back(std::move(page));
  }
  require_own(file, extension);
  write_file(file, extension == ".pdf" ? to_pdf(pages) : to_svg(board.page));
  if (o.json) {
    print_json({{"file", file.string()},
                {"board", to_text(target)},
                {"paper", board.paper},
                {"page_mm", {board.page.width_mm, board.page.height_mm}},
                {"print_left_top_mm", {board.left_mm, board.top_mm}},
                {"ruler_mm", board.ruler_mm},
                {"pages", pages.size()}});
  }
  context.progress.line(file.string() + ": " + board.paper + ", print it at 100 % and check its " +
                        std::to_string(static_cast<int>(board.ruler_mm)) + " mm ruler");
  return ExitCode::done;
}

}  // namespace cousin
