#include <algorithm>
#include <array>
#include <stdexcept>

#include "scenes/boards/boards_scene.h"
#include "scenes/boards/print_grid.h"
#include "scenes/boards/toml_text.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

Fields fields(BoardSetting::Poses& c) {
  return {
      {"tilt_min_rad", &c.tilt_min_rad, "least angle between the board and the picture", 0, 1.4},
      {"tilt_max_rad", &c.tilt_max_rad, "largest", 0, 1.4},
      {"roll_max_rad", &c.roll_max_rad, "about the optical axis, either way", 0, 3.1416},
      {"fill_min", &c.fill_min, "of the picture's width or height that the print spans", 0.05, 2},
      {"fill_max", &c.fill_max, "largest", 0.05, 2}};
}

Fields fields(BoardSetting::Video& c) {
  return {{"rate_hz", &c.rate_hz, "pictures a second", 1, 1000},
          {"pose_step_s", &c.pose_step_s, "from one planned pose past the next", 0.05, 100}};
}

Fields fields(BoardSetting::Place& c) {
  return {{"table_m", &c.table_m, "height of the table", 0.2, 2},
          {"stand_m", &c.stand_m, "height of the board's middle on a stand", 0.3, 3},
          {"wall_m", &c.wall_m, "from the board to the wall behind it", 0.3, 10},
          {"table_albedo", &c.table_albedo, "wood", 0, 1},
          {"table_dark", &c.table_dark, "its grain", 0, 1},
          {"wall_albedo", &c.wall_albedo, "paint", 0, 1},
          {"wall_dark", &c.wall_dark, "its stains", 0, 1},
          {"floor_albedo", &c.floor_albedo, "of the floor", 0, 1}};
}

Fields fields(BoardSetting::LightNumbers& c) {
  constexpr double kMost = 1e6;
  return {{"soft_room", &c.soft_room, "radiance of the room", 0, kMost},
          {"soft_panel", &c.soft_panel, "of the panel", 0, kMost},
          {"hard_room", &c.hard_room, "radiance of the room", 0, kMost},
          {"hard_lamp", &c.hard_lamp, "of the lamp", 0, kMost},
          {"sun_scale", &c.sun_scale, "radiance per kcd/m2", 0, kMost},
          {"sun_elevation_rad", &c.sun_elevation_rad, "of the sun", 0.05, 1.57},
          {"sun_turbidity", &c.sun_turbidity, "of the air", 1.7, 10}};
}

Fields fields(CalibrationTarget& c) {
  const TextField kind{[&c] { return std::string(to_string(c.kind)); },
                       [&c](const std::string& text) { c.kind = target_kind_from_string(text); }};
  return {
      {"kind", kind, "chessboard, charuco, april_grid, circles, asymmetric_circles or seed_board"},
      {"columns", &c.columns, "squares, tags or discs in a row", 1, 100},
      {"rows", &c.rows, "squares, tags or discs in a column", 1, 100},
      {"pitch_m", &c.pitch_m,
       "side of a square or tag; distance of discs (asymmetric: of their rows)", 1e-4, 10},
      {"mark_share", &c.mark_share,
       "charuco: marker over square; april_grid: space over tag; circles: radius over pitch; "
       "seed_board: marker over square",
       0, 3},
      {"dictionary", &c.dictionary, "charuco: of cv::aruco, such as DICT_5X5_100"}};
}

Fields file_fields(BoardsSceneConfig& c) {
  return nested("body", fields(c.body)) + nested("flaws", fields(c.flaws)) +
         nested("poses", fields(c.setting.poses)) + nested("video", fields(c.setting.video)) +
         nested("room", fields(c.setting.place)) + nested("lights", fields(c.setting.light));
}

constexpr std::array<const char*, 9> kNames = {"chessboard_a4", "chessboard_a2", "charuco_a4",
                                               "charuco_a2",    "aprilgrid_a0",  "aprilgrid_a4",
                                               "circles_a4",    "acircles_a4",   "seeds"};

std::vector<CalibrationTarget> read_presets() {
  std::vector<CalibrationTarget> targets(kNames.size());
  Fields all;
  for (std::size_t i = 0; i < kNames.size(); ++i) all = all + nested(kNames[i], fields(targets[i]));
  read_toml_text(board_presets_toml(), "scenes/boards/presets.toml", all, MissingKeys::error);
  for (const CalibrationTarget& target : targets) validate(target);
  return targets;
}

void require_one_of(const char* key, const std::string& value,
                    std::initializer_list<const char*> names) {
  std::string list;
  for (const char* name : names) {
    if (value == name) return;
    list += (list.empty() ? "" : ", ") + std::string(name);
  }
  throw std::invalid_argument(std::string(key) + " \"" + value + "\" is not one of " + list);
}

void require_ordered(const char* low_key, double low, const char* high_key, double high) {
  if (low <= high) return;
  throw std::invalid_argument(std::string(low_key) + " " + std::to_string(low) + " is above " +
                              high_key + " " + std::to_string(high));
}

}  // namespace

BoardsSceneConfig::BoardsSceneConfig() : target(board_preset(board)) {
  read_toml_text(boards_toml(), "scenes/boards/boards.toml", file_fields(*this),
                 MissingKeys::error);
}

std::vector<std::string> board_names() { return {kNames.begin(), kNames.end()}; }

CalibrationTarget board_preset(const std::string& name) {
  static const std::vector<CalibrationTarget> kPresets = read_presets();
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) {
    std::string known;
    for (const char* n : kNames) known += (known.empty() ? "" : ", ") + std::string(n);
    throw std::invalid_argument("board \"" + name + "\" is not one of " + known);
  }
  return kPresets[static_cast<std::size_t>(found - kNames.begin())];
}

Fields fields(BoardsSceneConfig& c) {
  const TextField board{[&c] { return c.board; },
                        [&c](const std::string& text) {
                          c.target = board_preset(text);
                          c.board = text;
                        }};
  return Fields{{"board", board,
                 "what is printed; sets all of target.*, which may follow: chessboard_a4, "
                 "chessboard_a2, charuco_a4, charuco_a2, aprilgrid_a0, aprilgrid_a4, circles_a4, "
                 "acircles_a4 or seeds"}} +
         nested("target", fields(c.target)) +
         Fields{{"place", &c.place,
                 "table: it lies; stand: it is upright; hand: held before a camera that stays"},
                {"light", &c.light, "soft (panel), hard (small lamp in a dim room) or sun"},
                {"views", &c.views, "photographs", 1, 10000},
                {"plan", &c.plan,
                 "planned: places, tilts and sizes spread evenly; random; or video: a camera that "
                 "moves past planned ones while its rows are read"},
                {"coverage", &c.coverage,
                 "share of the picture that the board's middle goes to; 0 = its middle", 0, 1},
                {"outside", &c.outside, "largest share of the print beyond the picture's border", 0,
                 0.9},
                {"rig", &c.rig, "sensor preset"}} +
         file_fields(c);
}

void validate(const BoardsSceneConfig& config) {
  BoardsSceneConfig copy = config;
  check_limits(fields(copy), "boards");
  require_one_of("place", config.place, {"table", "stand", "hand"});
  require_one_of("light", config.light, {"soft", "hard", "sun"});
  require_one_of("plan", config.plan, {"planned", "random", "video"});
  if (config.plan == "video" && config.place == "hand")
    throw std::invalid_argument(
        "plan \"video\" moves the camera; place \"hand\" keeps it still: take table or stand");
  const auto& poses = config.setting.poses;
  require_ordered("poses.tilt_min_rad", poses.tilt_min_rad, "poses.tilt_max_rad",
                  poses.tilt_max_rad);
  require_ordered("poses.fill_min", poses.fill_min, "poses.fill_max", poses.fill_max);
  if (poses.fill_max > 1 && config.outside == 0) {
    throw std::invalid_argument("poses.fill_max " + std::to_string(poses.fill_max) +
                                " is larger than the picture and outside is 0: no view can be so");
  }
  for (const auto* color : {&config.body.paper_albedo, &config.body.ink_albedo,
                            &config.body.plate_albedo, &config.setting.place.table_albedo,
                            &config.setting.place.table_dark, &config.setting.place.wall_albedo,
                            &config.setting.place.wall_dark, &config.setting.place.floor_albedo}) {
    if (color->size() != 3)
      throw std::invalid_argument("boards: a colour has " + std::to_string(color->size()) +
                                  " numbers; it needs 3");
  }
  print_grid(config.target, config.body.margin_m, config.body.detail_m);  // throws
}

}  // namespace cousin
