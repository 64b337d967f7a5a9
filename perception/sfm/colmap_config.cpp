#include <array>

#include "perception/sfm/colmap_run.h"
#include "sim/config/choice_field.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr std::array<Named<ColmapLens>, 3> kLenses = {
    {{ColmapLens::given, "given"}, {ColmapLens::focal, "focal"}, {ColmapLens::self, "self"}}};
constexpr std::array<Named<ColmapStatus>, 7> kColmapStatuses = {
    {{ColmapStatus::ok, "ok"},
     {ColmapStatus::too_few_images, "too_few_images"},
     {ColmapStatus::not_built, "not_built"},
     {ColmapStatus::program_failed, "program_failed"},
     {ColmapStatus::timed_out, "timed_out"},
     {ColmapStatus::no_model, "no_model"},
     {ColmapStatus::no_lens, "no_lens"}}};

}  // namespace

std::string_view to_string(ColmapLens lens) { return name_in<ColmapLens>(kLenses, lens); }
std::string_view to_string(ColmapStatus status) {
  return name_in<ColmapStatus>(kColmapStatuses, status);
}

Fields fields(ColmapConfig& config) {
  return {{"program", &config.program, "a name in PATH, or a file"},
          {"folder", &config.folder, "keeps its files, to go on there; empty: a scratch folder"},
          {"lens", choice_field<ColmapLens>("lens", kLenses, config.lens),
           "given, focal (refined) or self (nothing is given)"},
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
