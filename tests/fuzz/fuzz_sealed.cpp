#include <stdexcept>
#include <string>

#include "sim/dataset/sealed_file.h"
#include "tests/fuzz/fuzz_folder.h"

/// Any bytes as a kept training, a stand at rest or a kept capture: the body that was sealed, or
/// std::runtime_error. What is sealed is read again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  constexpr std::size_t kLimit = 1 << 20;
  const auto file = fuzz_file("sealed", data, size);
  try {
    read_sealed(file, "cousin fuzz 1", "kept thing", kLimit);
  } catch (const std::runtime_error&) {
  }
  if (size > 4096) return 0;
  const std::string body(reinterpret_cast<const char*>(data), size);
  write_sealed(file, "cousin fuzz 1\n" + body);
  if (read_sealed(file, "cousin fuzz 1", "kept thing", kLimit) != body) __builtin_trap();
  return 0;
}
