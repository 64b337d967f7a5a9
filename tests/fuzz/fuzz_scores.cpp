#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "benchmarks/score/scores.h"

/// Any bytes as scores.csv, specimens.csv and scores.json: rows that can be written and read again,
/// or std::runtime_error, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto attempt = [](auto read, auto again) {
    decltype(read()) value;
    try {
      value = read();
    } catch (const std::runtime_error&) {
      return;
    }
    again(value);
  };
  attempt([&] { return scores_from_csv(text, "fuzz"); },
          [](const auto& rows) { scores_from_csv(to_csv(rows), "again"); });
  attempt([&] { return specimens_from_csv(text, "fuzz"); },
          [](const auto& rows) { specimens_from_csv(to_csv(rows), "again"); });
  attempt([&] { return scores_from_json(text, "fuzz"); },
          [](const auto& file) { scores_from_json(to_json(file), "again"); });
  return 0;
}
