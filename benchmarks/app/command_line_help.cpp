#include "benchmarks/app/command_line_help.h"

#include <cstddef>
#include <sstream>

namespace cousin {
namespace {

/// Lines that break at blanks, of 100 columns beside the names of options.
std::string in_lines(const std::string& text, std::size_t beside) {
  constexpr std::size_t kColumns = 100;
  std::string lines;
  std::size_t used = 0;
  std::istringstream words(text);
  for (std::string word; words >> word; used += word.size()) {
    if (used > 0 && beside + used + 1 + word.size() > kColumns) {
      lines += "\n";
      used = 0;
    } else if (used > 0) {
      lines += " ";
      ++used;
    }
    lines += word;
  }
  return lines;
}

/// Text after the options in the help of a verb.
struct Closing {
  const char* verb;
  const char* out;  ///< where it writes without --out; nullptr = it writes no files
  const char* examples;
};
constexpr Closing kClosings[] = {
    {"scenes", nullptr, "  cousin scenes"},
    {"rigs", nullptr, "  cousin rigs"},
    {"methods", nullptr, "  cousin methods"},
    {"doctor", nullptr, "  cousin doctor"},
    {"render", "out/SCENE_dataset",
     "  cousin render seeds --plan\n"
     "  cousin render seeds --scenes 2 --out out/data\n"
     "  cousin render maize --set stage=V10 --truth keypoints,part --out out/maize"},
    {"perceive", "DATASET_estimate",
     "  cousin perceive out/data --out out/est\n"
     "  cousin perceive out/posed --pipeline scene"},
    {"score", "ESTIMATE_DIR", "  cousin score out/data out/est --gate 'length.rmse<=0.0001'"},
    {"run", "out/seeds; of --pipeline scene out/SCENE_views",
     "  cousin run seeds --plan\n"
     "  cousin run seeds --set cultivar=jimai22 --out out/wheat\n"
     "  cousin run seedlings --pipeline scene --set knows_pose=true"},
    {"measure", "out/measured_SOURCE",
     "  cousin measure seeds.mp4 --ruler 99.7 --expect 10 --out out/mine\n"
     "  cousin measure maize_a/ maize_b/ --group cultivar"},
    {"board", "out/board_BOARD.pdf",
     "  cousin board seeds --paper a4 --out board.pdf\n"
     "  cousin board charuco_a4 --out charuco.svg"},
    {"calibrate", "out/calibrate",
     "  cousin calibrate photos --board chessboard:6x4:0.030 --out calibration"},
    {"fit-sensor", "out/fit_sensor", "  cousin fit-sensor desk --rig d457 --out fit"},
    {"bench", "out/bench",
     "  cousin bench program\n"
     "  cousin bench seeds --quick --out out/bench"},
    {"import", "out/NAME, as SOURCE is named",
     "  cousin import photos --format folder --intrinsics 1088,1088,640,360 --out out/real\n"
     "  cousin import workspace --format colmap --out out/posed\n"
     "  cousin import shots --format rgbd --depth-unit 0.001 --out out/shots"},
    {"export", "DATASET_FORMAT; kit: out/kit",
     "  cousin export out/data --format coco --out out/coco\n"
     "  cousin export kit --out out/kit"},
    {"verify", nullptr, "  cousin verify out/data"},
    {"report", "FOLDER", "  cousin report out/seeds"},
};

const Closing* closing_of(std::string_view verb) {
  for (const Closing& closing : kClosings) {
    if (verb == closing.verb) return &closing;
  }
  return nullptr;
}

}  // namespace

std::string HelpText::make_subcommand(const CLI::App* verb) const {
  const std::string text = verb->get_description();
  const std::string first = text.substr(0, text.find_first_of(".\n"));
  std::ostringstream out;
  CLI::detail::format_help(out, verb->get_name(), in_lines(first, get_column_width()),
                           get_column_width());
  return out.str();
}

std::string HelpText::make_option_desc(const CLI::Option* option) const {
  return in_lines(option->get_description(), get_column_width());
}

bool writes_files(std::string_view verb) {
  const Closing* closing = closing_of(verb);
  return closing != nullptr && closing->out != nullptr;
}

std::string closing_text(std::string_view verb) {
  const Closing* found = closing_of(verb);
  if (found == nullptr) return {};
  const Closing& closing = *found;
  std::string text = "Also --seed N, --threads N, --json, --quiet";
  if (closing.out != nullptr) text += std::string(", --out FOLDER (default ") + closing.out + ")";
  return text + "; see `cousin --help`.\n\nExample:\n" + closing.examples;
}

std::string first_steps(const CLI::App& app) {
  std::ostringstream text;
  text << "cousin: no verb is given. Verbs:\n";
  const HelpText verbs;
  for (const CLI::App* verb : app.get_subcommands(nullptr)) text << verbs.make_subcommand(verb);
  text << "Try\n"
          "  cousin run seeds          ten seeds: rendered, measured, scored, with a page\n"
          "  cousin run seeds --plan   what that would do\n"
          "  cousin help run           all of a verb's options\n"
          "See `cousin --help`.\n";
  return text.str();
}

}  // namespace cousin
