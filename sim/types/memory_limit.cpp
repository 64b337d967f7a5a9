#include "sim/types/memory_limit.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

constexpr std::uint64_t kGiB = std::uint64_t{1} << 30;
constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();

std::atomic<std::uint64_t> set_limit_bytes{0};

/// The number that the file holds; the largest one if it holds none ("max").
std::uint64_t number_in(const char* file) {
  std::ifstream in(file);
  std::uint64_t number = 0;
  return in >> number ? number : kLargest;
}

/// What this process may have: the machine's memory, or less if a container or a shell says so.
std::uint64_t memory_of_process_bytes() {
  const long pages = sysconf(_SC_PHYS_PAGES), page_bytes = sysconf(_SC_PAGESIZE);
  std::uint64_t bytes = kLargest;
  if (pages > 0 && page_bytes > 0)
    bytes = static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes);
  bytes = std::min(bytes, number_in("/sys/fs/cgroup/memory.max"));
  bytes = std::min(bytes, number_in("/sys/fs/cgroup/memory/memory.limit_in_bytes"));
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    bytes = std::min<std::uint64_t>(bytes, limit.rlim_cur);
  return bytes;
}

std::string shown_bytes(std::uint64_t bytes) {
  if (bytes == kLargest) return "more bytes than can be counted";
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%llu bytes (%.2f GiB)",
                static_cast<unsigned long long>(bytes),
                static_cast<double>(bytes) / static_cast<double>(kGiB));
  return text.data();
}

}  // namespace

std::uint64_t default_memory_limit_bytes() {
  static const std::uint64_t bytes = std::min(8 * kGiB, memory_of_process_bytes() / 2);
  return bytes;
}

std::uint64_t memory_limit_bytes() {
  const std::uint64_t bytes = set_limit_bytes;
  return bytes > 0 ? bytes : default_memory_limit_bytes();
}

void set_memory_limit(std::uint64_t bytes) { set_limit_bytes = bytes; }

void check_memory(const std::filesystem::path& file, std::uint64_t bytes, std::string_view what) {
  const std::uint64_t limit = memory_limit_bytes();
  if (bytes <= limit) return;
  throw std::runtime_error(file.string() + ": " + std::string(what) + " would take " +
                           shown_bytes(bytes) + " of memory; the limit is " + shown_bytes(limit) +
                           ", set by --memory-limit");
}

std::uint64_t bytes_times(std::uint64_t a, std::uint64_t b) {
  return a != 0 && b > kLargest / a ? kLargest : a * b;
}

std::uint64_t bytes_plus(std::uint64_t a, std::uint64_t b) {
  return b > kLargest - a ? kLargest : a + b;
}

}  // namespace cousin
