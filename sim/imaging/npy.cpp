// A .npy file: the magic bytes, a version of two bytes, the length of the text (2 bytes in version
// 1, 4 in versions 2 and 3), a Python dictionary as text, and the numbers:
//   {'descr': '<f4', 'fortran_order': False, 'shape': (720, 1280), }
#include "sim/imaging/npy.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "sim/imaging/codecs.h"
#include "sim/imaging/file_bytes.h"
#include "sim/types/memory_limit.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace imaging {
namespace {

static_assert(std::endian::native == std::endian::little, "the files are little-endian");
static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));

constexpr std::string_view kNpyMagic = "\x93NUMPY";
constexpr std::size_t kNpyMostText = 10000;  // as numpy.load
constexpr std::size_t kNpyMostStart = kNpyMagic.size() + 2 + 4 + kNpyMostText;
constexpr std::uint64_t kNpyMostBytes = std::uint64_t{1} << 31;  // as read_bytes
constexpr std::string_view kBlanks = " \t\r\n";

struct NpyHeader {
  std::uint64_t width = 0, height = 0;
  std::uint64_t channels = 1;
  std::size_t data_at = 0;  ///< byte of the first number
};

[[noreturn]] void fail_npy(const std::string& name, const std::string& what) {
  throw std::runtime_error(name + ": NPY: " + what);
}

std::string shown(std::string_view text) { return terminal_text(cut_utf8(text, 60)); }

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// Where the text has the first of `ends` that stands outside of quotes and brackets; its size if
/// nowhere.
std::size_t end_of_part(std::string_view text, std::string_view ends) {
  int depth = 0;
  char quote = '\0';
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quote != '\0') {
      if (c == quote) quote = '\0';
      continue;
    }
    if (depth == 0 && ends.find(c) != std::string_view::npos) return i;
    if (c == '\'' || c == '"') quote = c;
    if (c == '(' || c == '[') ++depth;
    if (c == ')' || c == ']') --depth;
  }
  return text.size();
}

/// A Python string's inside; empty if it is none.
std::string_view unquoted(std::string_view text) {
  const bool is_quoted = text.size() >= 2 && (text.front() == '\'' || text.front() == '"') &&
                         text.back() == text.front();
  return is_quoted ? text.substr(1, text.size() - 2) : std::string_view();
}

/// The dictionary's entries, values as they are written.
std::map<std::string_view, std::string_view> entries_of(std::string_view text,
                                                        const std::string& name) {
  const std::string_view whole = trimmed(text);
  if (whole.size() < 2 || whole.front() != '{' || whole.back() != '}')
    fail_npy(name, "the header \"" + shown(whole) + "\" is no dictionary");
  std::string_view rest = whole.substr(1, whole.size() - 2);
  std::map<std::string_view, std::string_view> entries;
  while (!trimmed(rest).empty()) {
    const std::string_view entry = rest.substr(0, end_of_part(rest, ","));
    rest.remove_prefix(std::min(entry.size() + 1, rest.size()));
    const std::size_t colon = end_of_part(entry, ":");
    const std::string_view key = unquoted(trimmed(entry.substr(0, colon)));
    if (colon == entry.size() || key.empty())
      fail_npy(name, "the header has \"" + shown(trimmed(entry)) + "\", no key and value");
    if (key != "descr" && key != "fortran_order" && key != "shape")
      fail_npy(name, "unknown key \"" + shown(key) + "\" in the header");
    if (!entries.emplace(key, trimmed(entry.substr(colon + 1))).second)
      fail_npy(name, "the key " + std::string(key) + " occurs twice in the header");
  }
  for (const char* key : {"descr", "fortran_order", "shape"}) {
    if (!entries.contains(key)) fail_npy(name, std::string("the header lacks the key ") + key);
  }
  return entries;
}

/// "(720, 1280)" as numbers. @param wanted  in words, what it should be
std::vector<std::uint64_t> shape_of(std::string_view text, const std::string& name,
                                    const std::string& wanted) {
  const auto fail = [&] { fail_npy(name, "shape = " + shown(text) + "; expected " + wanted); };
  if (text.size() < 2 || text.front() != '(' || text.back() != ')') fail();
  std::string_view rest = text.substr(1, text.size() - 2);
  std::vector<std::uint64_t> shape;
  while (!trimmed(rest).empty()) {
    const std::string_view part = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(part.size() + 1, rest.size()));
    const std::string_view digits = trimmed(part);
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc{} || end != digits.data() + digits.size() || shape.size() == 3) fail();
    shape.push_back(value);
  }
  return shape;
}

/// Of the text between the lengths and the numbers.
NpyHeader parse_npy_text(std::string_view text, const std::string& name, std::uint64_t channels) {
  const auto entries = entries_of(text, name);
  if (unquoted(entries.at("descr")) != "<f4") {
    fail_npy(name, "descr = " + shown(entries.at("descr")) +
                       "; expected '<f4', which is numpy.float32, little endian");
  }
  if (entries.at("fortran_order") != "False") {
    fail_npy(name, "fortran_order = " + shown(entries.at("fortran_order")) +
                       "; expected False, as numpy.ascontiguousarray gives it");
  }
  const std::string wanted =
      channels == 1
          ? "(height, width)"
          : (channels == 0 ? "(height, width) or (height, width, 3)" : "(height, width, 3)");
  const std::vector<std::uint64_t> shape = shape_of(entries.at("shape"), name, wanted);
  const std::uint64_t there = shape.size() == 2 ? 1 : shape.size() == 3 && shape[2] == 3 ? 3 : 0;
  if (there == 0 || (channels != 0 && there != channels))
    fail_npy(name, "shape = " + shown(entries.at("shape")) + "; expected " + wanted);
  check_image_size(name + ": NPY", shape[1], shape[0]);
  return {.width = shape[1], .height = shape[0], .channels = there};
}

/// @param start  of the file, whole or at least kNpyMostStart bytes
/// @param channels  1 or 3; 0 = either
NpyHeader parse_npy_header(std::string_view start, std::uint64_t file_bytes,
                           const std::string& name, std::uint64_t channels) {
  if (!start.starts_with(kNpyMagic))
    throw std::runtime_error(name + ": not a NPY file: it does not begin with \\x93NUMPY");
  const auto byte = [&](std::size_t at) -> std::size_t {
    if (at >= start.size()) fail_npy(name, "truncated in its header");
    return static_cast<unsigned char>(start[at]);
  };
  const std::size_t major = byte(6), minor = byte(7);
  if (major < 1 || major > 3 || minor != 0) {
    fail_npy(name, "version " + std::to_string(major) + "." + std::to_string(minor) +
                       "; expected 1.0, 2.0 or 3.0");
  }
  const std::size_t length_bytes = major == 1 ? 2 : 4, text_at = 8 + length_bytes;
  std::size_t length = 0;
  for (std::size_t i = length_bytes; i-- > 0;) length = 256 * length + byte(8 + i);
  if (length > kNpyMostText) {
    fail_npy(name, "a header of " + std::to_string(length) + " bytes; the limit is " +
                       std::to_string(kNpyMostText));
  }
  if (length > start.size() - text_at) fail_npy(name, "truncated in its header");
  NpyHeader header = parse_npy_text(start.substr(text_at, length), name, channels);
  header.data_at = text_at + length;
  const std::uint64_t needed = header.width * header.height * header.channels * sizeof(float);
  if (file_bytes - header.data_at != needed) {
    fail_npy(name, std::to_string(file_bytes - header.data_at) +
                       " bytes follow the header; its shape needs " + std::to_string(needed));
  }
  return header;
}

template <class Pixel>
Image<Pixel> decode_npy_as(std::span<const std::uint8_t> bytes, const std::string& name) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const NpyHeader header =
      parse_npy_header(text, bytes.size(), name, sizeof(Pixel) / sizeof(float));
  const std::uint64_t pixels = header.width * header.height;
  check_memory(name, 2 * pixels * sizeof(Pixel),
               "an image of " + std::to_string(header.width) + " x " +
                   std::to_string(header.height) + " pixels");
  Image<Pixel> image(static_cast<int>(header.width), static_cast<int>(header.height), Pixel());
  std::memcpy(static_cast<void*>(image.data()), bytes.data() + header.data_at,
              pixels * sizeof(Pixel));
  return image;
}

template <class Pixel>
std::vector<std::uint8_t> encode_npy(const Image<Pixel>& image) {
  check_encodable(image.width(), image.height());
  const std::uint64_t numbers = image.size() * sizeof(Pixel);
  std::string text = "{'descr': '<f4', 'fortran_order': False, 'shape': (" +
                     std::to_string(image.height()) + ", " + std::to_string(image.width()) +
                     (sizeof(Pixel) == sizeof(float) ? "" : ", 3") + "), }";
  // The numbers begin at a multiple of 64 bytes, as numpy.save puts them.
  const std::size_t before = kNpyMagic.size() + 4;
  text.append((64 - (before + text.size() + 1) % 64) % 64, ' ');
  text += '\n';
  if (before + text.size() + numbers > kNpyMostBytes) {
    throw std::invalid_argument("an image of " + std::to_string(image.width()) + " x " +
                                std::to_string(image.height()) + " pixels takes " +
                                std::to_string(numbers) + " bytes; the limit is 2^31");
  }
  std::string start(kNpyMagic);
  start += '\x01';
  start += '\x00';
  start += static_cast<char>(text.size() % 256);
  start += static_cast<char>(text.size() / 256);
  start += text;
  std::vector<std::uint8_t> bytes(start.size() + numbers);
  std::memcpy(bytes.data(), start.data(), start.size());
  std::memcpy(bytes.data() + start.size(), image.data(), numbers);
  return bytes;
}

}  // namespace

Image<float> decode_npy(std::span<const std::uint8_t> bytes, const std::string& name) {
  return decode_npy_as<float>(bytes, name);
}

Image<Eigen::Vector3f> decode_npy_vectors(std::span<const std::uint8_t> bytes,
                                          const std::string& name) {
  return decode_npy_as<Eigen::Vector3f>(bytes, name);
}

}  // namespace imaging

void write_npy(const std::filesystem::path& file, const Image<float>& image) {
  imaging::replace_file(file, imaging::encode_npy(image));
}

void write_npy(const std::filesystem::path& file, const Image<Eigen::Vector3f>& image) {
  imaging::replace_file(file, imaging::encode_npy(image));
}

Image<float> read_npy(const std::filesystem::path& file) {
  return imaging::decode_npy(imaging::read_bytes(file), file.string());
}

Image<Eigen::Vector3f> read_npy_vectors(const std::filesystem::path& file) {
  return imaging::decode_npy_vectors(imaging::read_bytes(file), file.string());
}

std::uint64_t npy_pixels(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string start(imaging::kNpyMostStart, '\0');
  stream.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(stream.gcount()));
  std::error_code none;
  const std::uintmax_t size = std::filesystem::file_size(file, none);
  if (none || start.size() > size)
    throw std::runtime_error(file.string() + ": cannot read: " + none.message());
  const imaging::NpyHeader header = imaging::parse_npy_header(start, size, file.string(), 0);
  return header.width * header.height;
}

}  // namespace cousin
