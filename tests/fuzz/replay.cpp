// Runs a fuzz target over the files of a folder, and over each cut short and with one byte changed:
// what the fuzzer starts from, and what it once found, on any compiler.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

void run(const std::string& bytes) {
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
}

/// The file, 64 cuts of it and 256 changes of a byte.
void run_around(const std::string& bytes) {
  constexpr std::size_t kCuts = 64, kChanges = 256;
  run(bytes);
  for (std::size_t i = 0; i < kCuts; ++i) run(bytes.substr(0, bytes.size() * i / kCuts));
  for (std::size_t i = 0; i < kChanges && !bytes.empty(); ++i) {
    std::string changed = bytes;
    constexpr char kBytes[] = {'-', '9', 'e', '"', '[', '}', '\0', '\xff'};
    changed[(i * 2654435761U) % bytes.size()] = kBytes[i % sizeof kBytes];
    run(changed);
  }
}

}  // namespace

int main(int argc, char** argv) {
  int files = 0;
  for (int i = 1; i < argc; ++i) {
    for (const auto& entry : std::filesystem::directory_iterator(argv[i])) {
      std::ifstream in(entry.path(), std::ios::binary);
      const std::string bytes((std::istreambuf_iterator<char>(in)), {});
      std::printf("%s\n", entry.path().c_str());
      std::fflush(stdout);
      try {
        run_around(bytes);
      } catch (const std::exception& error) {
        std::printf("let through: %s\n", error.what());
        return 1;
      }
      ++files;
    }
  }
  if (files == 0) std::printf("no files to run\n");
  return files > 0 ? 0 : 1;
}
