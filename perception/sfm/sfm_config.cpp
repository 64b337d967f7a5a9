#include <algorithm>
#include <array>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "perception/sfm/sfm_poses.h"
#include "sim/config/choice_field.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr std::array<Named<SfmScale>, 3> kScales = {
    {{SfmScale::adjusted, "adjusted"}, {SfmScale::squares, "squares"}, {SfmScale::none, "none"}}};
constexpr std::array<Named<SfmFocal>, 2> kFocals = {
    {{SfmFocal::shared, "shared"}, {SfmFocal::per_image, "per_image"}}};
constexpr std::array<Named<SfmStatus>, 11> kStatuses = {
    {{SfmStatus::ok, "ok"},
     {SfmStatus::partly_registered, "partly_registered"},
     {SfmStatus::no_scale, "no_scale"},
     {SfmStatus::contradicted, "contradicted"},
     {SfmStatus::not_determined, "not_determined"},
     {SfmStatus::not_converged, "not_converged"},
     {SfmStatus::too_few_images, "too_few_images"},
     {SfmStatus::no_model, "no_model"},
     {SfmStatus::program_failed, "program_failed"},
     {SfmStatus::timed_out, "timed_out"},
     {SfmStatus::not_built, "not_built"}}};

}  // namespace

std::string_view to_string(SfmScale scale) { return name_in<SfmScale>(kScales, scale); }
std::string_view to_string(SfmStatus status) { return name_in<SfmStatus>(kStatuses, status); }

Fields fields(SfmConfig& config) {
  return nested("pairs", fields(config.pairs)) + nested("colmap", fields(config.colmap)) +
         nested("board", fields(config.board)) +
         Fields{{"scale", choice_field<SfmScale>("scale", kScales, config.scale),
                 "adjusted (board in the adjustment), squares (one factor) or none"},
                {"refine", &config.refine, "our own adjustment of poses and lens"},
                {"focal", choice_field<SfmFocal>("focal", kFocals, config.focal),
                 "shared, or per_image about the shared one"},
                {"focal_jitter", &config.focal_jitter,
                 "relative deviation of one image's focal length about all's", 1e-9, 1},
                {"board_sigma_m", &config.board_sigma_m, "of a corner's coordinate", 1e-9, 1},
                {"corner_floor_px", &config.corner_floor_px,
                 "added in quadrature to each corner's deviation", 0, 100},
                {"min_board_corners", &config.min_board_corners, "fewer: no scale", 4, 1000},
                {"place_by_board", &config.place_by_board,
                 "images that COLMAP lost enter the adjustment by the board"},
                {"max_board_turn_rad", &config.max_board_turn_rad,
                 "images that the board turns by more are taken out", 0, 3.2}} +
         nested("adjust", fields(config.adjust));
}

Fields fields_of_pipelines(SfmConfig& config) {
  constexpr std::string_view kOwn[] = {"focal", "focal_jitter", "refine"};
  constexpr std::string_view kColmap[] = {"lens",         "lens_per_image", "threads",
                                          "max_features", "match_lost",     "time_limit_s"};
  const auto is_of = [](std::span<const std::string_view> keys, const Field& field) {
    return std::find(keys.begin(), keys.end(), field.key) != keys.end();
  };
  Fields chosen, of_colmap = fields(config.colmap);
  for (Field& field : fields(config)) {
    if (is_of(kOwn, field)) chosen.push_back(std::move(field));
  }
  std::erase_if(of_colmap, [&](const Field& field) { return !is_of(kColmap, field); });
  return chosen + nested("colmap", std::move(of_colmap));
}

void validate(const SfmConfig& config) {
  SfmConfig copy = config;  // fields point into what they describe
  check_limits(fields(copy));
  validate(config.board);
  if (config.adjust.zoom_share != 0) {
    throw std::invalid_argument("adjust.zoom_share = " + std::to_string(config.adjust.zoom_share) +
                                ": here focal = per_image and focal_jitter say it");
  }
  if (config.scale == SfmScale::adjusted && !config.refine) {
    throw std::invalid_argument(
        "scale = adjusted needs refine = true: the board is part of that adjustment");
  }
}

SfmConfig paper_sfm_config() {
  SfmConfig config;
  config.colmap.lens = ColmapLens::self;
  config.scale = SfmScale::squares;
  config.refine = false;
  return config;
}

}  // namespace cousin
