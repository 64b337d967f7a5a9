#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "benchmarks/report/html.h"
#include "sim/types/utf8.h"

/// Any bytes on a page and on a terminal: no markup, no control character, always UTF-8.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto require = [](bool holds) {
    if (!holds) __builtin_trap();
  };
  const std::string shown = html_text(text).str();
  require(shown.find_first_of("<>\"'\x1b\x7f") == std::string::npos && is_utf8(shown));
  const std::string json = html_json(nlohmann::ordered_json{{std::string(text), text}}).str();
  require(json.find('<') == std::string::npos && is_utf8(json));
  require(!nlohmann::json::parse(json, nullptr, false).is_discarded());
  const std::string line = terminal_text(text);
  require(is_utf8(line) && line.find_first_of("\x1b\r\x7f") == std::string::npos);
  for (std::size_t at = line.find('\n'); at != std::string::npos; at = line.find('\n', at + 1))
    require(line.compare(at, 3, "\n  ") == 0);
  const std::string readable = readable_utf8(text);
  require(is_utf8(readable) && (!is_utf8(text) || readable == text));
  for (const std::size_t most : {std::size_t{0}, size / 2, size})
    require(cut_utf8(text, most).size() <= most &&
            (!is_utf8(text) || is_utf8(cut_utf8(text, most))));
  return 0;
}
