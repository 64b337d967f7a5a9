#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "sim/config/fields.h"

/// Any bytes as a configuration, and as an assignment of --set: read, or refused by the exceptions
/// that are promised. What was read is written and reads back.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  double length_m = 0.1;
  int count = 3;
  std::uint64_t seed = 1;
  bool fast = false;
  std::string name = "x";
  std::vector<double> list = {1};
  const Fields fields = {{"a", &length_m, "", 0, 1}, {"b", &count, "", -5, 5}, {"c.s", &seed, ""},
                         {"c.f", &fast, ""},         {"c.d.n", &name, ""},     {"l", &list, ""}};
  try {
    read_toml_text(text, "fuzz", fields, MissingKeys::keep_default);
    const std::string written = to_toml(fields);
    read_toml_text(written, "round trip", fields, MissingKeys::error);
    if (to_toml(fields) != written) std::abort();
  } catch (const std::runtime_error& error) {
    if (std::string_view(error.what()).starts_with("round trip")) std::abort();
  }
  try {
    set_field(fields, text);
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
