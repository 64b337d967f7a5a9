#include <charconv>
#include <string>
#include <string_view>

#include "benchmarks/score/score_columns.h"

namespace cousin {
namespace {

/// The whole number that ends before `end`; 0 if there is none.
std::int64_t number_before(std::string_view text, std::size_t end) {
  std::size_t begin = end;
  while (begin > 0 && text[begin - 1] >= '0' && text[begin - 1] <= '9') --begin;
  std::int64_t value = 0;
  std::from_chars(text.data() + begin, text.data() + end, value);
  return value;
}

/// The whole number after `at`; `none` if there is none.
std::int64_t number_after(std::string_view text, std::size_t at, std::int64_t none) {
  std::int64_t value = none;
  std::from_chars(text.data() + at, text.data() + text.size(), value);
  return value;
}

/// "1920x1080" anywhere in a name.
void read_size(std::string_view name, ScoreRow& row) {
  for (std::size_t x = name.find('x'); x != std::string_view::npos; x = name.find('x', x + 1)) {
    const std::int64_t width = number_before(name, x), height = number_after(name, x + 1, 0);
    if (width == 0 || height == 0) continue;
    row.width_px = width;
    row.height_px = height;
    return;
  }
}

}  // namespace

void settings_of_schema_1(ScoreRow& row) {
  const std::string_view name = row.case_name;
  const auto place = [&](std::string_view words) { return name.find(words); };
  constexpr std::size_t kNowhere = std::string_view::npos;
  if (const auto at = place(" run "); at != kNowhere) row.run = number_after(name, at + 5, -1);
  if (name.starts_with("sample ")) row.run = number_after(name, 7, -1);
  if (const auto at = place(" views"); at != kNowhere) row.views = number_before(name, at);
  if (name.ends_with(" steps")) row.steps = number_before(name, name.size() - 6);
  if (const auto at = place("one in "); at != kNowhere)
    row.held_out_every = number_after(name, at + 7, 0);
  if (const auto at = place(", poses "); at != kNowhere) {
    const std::size_t begin = at + 8;
    row.poses = name.substr(begin, name.find(',', begin) - begin);
  }
  if (place("one side") != kNowhere) row.view_set = "one side";
  read_size(name, row);
}

}  // namespace cousin
