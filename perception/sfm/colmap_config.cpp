#include <array>
#include <stdexcept>

#include "perception/sfm/colmap_run.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr std::array kLenses = {ColmapLens::given, ColmapLens::focal, ColmapLens::self};

TextField lens_field(ColmapLens& lens) {
  return {[&lens] { return std::string(to_string(lens)); },
          [&lens](const std::string& text) {
            for (const ColmapLens each : kLenses) {
              if (text == to_string(each)) {
                lens = each;
                return;
              }
            }
            throw std::invalid_argument("lens \"" + text + "\" is not given, focal or self");
          }};
}

}  // namespace

std::string_view to_string(ColmapLens lens) {
  switch (lens) {
    case ColmapLens::given:
      return "given";
    case ColmapLens::focal:
      return "focal";
    case ColmapLens::self:
      return "self";
  }
  throw std::invalid_argument("lens " + std::to_string(static_cast<int>(lens)) + " does not exist");
}

std::string_view to_string(ColmapStatus status) {
  switch (status) {
    case ColmapStatus::ok:
      return "ok";
    case ColmapStatus::too_few_images:
      return "too_few_images";
    case ColmapStatus::not_built:
      return "not_built";
    case ColmapStatus::program_failed:
      return "program_failed";
    case ColmapStatus::timed_out:
      return "timed_out";
    case ColmapStatus::no_model:
      return "no_model";
    case ColmapStatus::no_lens:
      return "no_lens";
  }
  throw std::invalid_argument("status " + std::to_string(static_cast<int>(status)) +
                              " does not exist");
}

Fields fields(ColmapConfig& config) {
  return {{"program", &config.program, "a name in PATH, or a file"},
          {"folder", &config.folder, "keeps its files, to go on there; empty: a scratch folder"},
          {"lens", lens_field(config.lens), "given, focal (refined) or self (nothing is given)"},
          {"lens_per_image", &config.lens_per_image, "else all images share one"},
          {"threads", &config.threads, "COLMAP's models vary with it", 1, 256},
          {"max_features", &config.max_features, "of an image", 100, 100000},
          {"match_lost", &config.match_lost,
           "images without a place are matched with all others, then all are mapped again"},
          {"time_limit_s", &config.time_limit_s, "of all steps together", 0.01, 1e6}};
}

void validate(const ColmapConfig& config) {
  ColmapConfig copy = config;  // fields point into what they describe
  check_limits(fields(copy));
}

}  // namespace cousin
