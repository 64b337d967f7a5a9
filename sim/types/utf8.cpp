#include "sim/types/utf8.h"

#include <array>
#include <cstdint>
#include <cstdio>

namespace cousin {
namespace {

bool is_between(char c, unsigned low, unsigned high) {
  const auto byte = static_cast<unsigned char>(c);
  return byte >= low && byte <= high;
}

bool is_continuation(char c) { return is_between(c, 0x80, 0xbf); }

/// Bytes that a character with this first byte has; 0 if no character begins with it.
std::size_t bytes_after(unsigned char first) {
  if (first < 0x80) return 1;
  if (first < 0xc2) return 0;
  if (first < 0xe0) return 2;
  if (first < 0xf0) return 3;
  return first < 0xf5 ? 4 : 0;
}

std::string shown_byte(char c) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "\\x%02x", static_cast<unsigned char>(c));
  return text.data();
}

/// The number of a character that is well formed.
std::uint32_t code_point(std::string_view character) {
  static constexpr std::array<unsigned, 5> kMask = {0, 0x7f, 0x1f, 0x0f, 0x07};
  std::uint32_t code = static_cast<unsigned char>(character[0]) & kMask[character.size()];
  for (const char c : character.substr(1)) code = code << 6 | (static_cast<unsigned char>(c) & 63U);
  return code;
}

/// Moves the cursor, changes the colours or turns the direction of what follows; or breaks a line
/// where no line break is meant (U+2028, U+2029).
bool acts_on_terminal(std::uint32_t code) {
  return code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0x61c || code == 0x200e ||
         code == 0x200f || (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
}

std::string shown_character(std::string_view character) {
  if (character.size() == 1) return shown_byte(character[0]);
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "\\u%04x", code_point(character));
  return text.data();
}

}  // namespace

std::size_t utf8_character_bytes(std::string_view text) {
  if (text.empty()) return 0;
  const auto first = static_cast<unsigned char>(text[0]);
  const std::size_t count = bytes_after(first);
  if (count == 0 || text.size() < count) return 0;
  for (std::size_t i = 1; i < count; ++i) {
    if (!is_continuation(text[i])) return 0;
  }
  // The second byte says whether the form is overlong, a surrogate or above U+10FFFF.
  if (first == 0xe0 && !is_between(text[1], 0xa0, 0xbf)) return 0;
  if (first == 0xed && !is_between(text[1], 0x80, 0x9f)) return 0;
  if (first == 0xf0 && !is_between(text[1], 0x90, 0xbf)) return 0;
  if (first == 0xf4 && !is_between(text[1], 0x80, 0x8f)) return 0;
  return count;
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t count = utf8_character_bytes(text);
    if (count == 0) return false;
    text.remove_prefix(count);
  }
  return true;
}

std::string readable_utf8(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const std::size_t count = utf8_character_bytes(text);
    if (count == 0)
      result += shown_byte(text[0]);
    else
      result += text.substr(0, count);
    text.remove_prefix(count == 0 ? 1 : count);
  }
  return result;
}

std::string cut_utf8(std::string_view text, std::size_t most_bytes) {
  if (text.size() <= most_bytes) return std::string(text);
  std::size_t start = most_bytes;  // of the character that the limit would cut
  while (start > 0 && most_bytes - start < 3 && is_continuation(text[start])) --start;
  // Bytes that are no character are cut where the limit says.
  const bool cuts = start + utf8_character_bytes(text.substr(start)) > most_bytes;
  return std::string(text.substr(0, cuts ? start : most_bytes));
}

std::string terminal_text(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const std::size_t count = utf8_character_bytes(text);
    const std::string_view character = text.substr(0, count == 0 ? 1 : count);
    const bool stays = text[0] == '\t';
    if (count == 0 || (!stays && acts_on_terminal(code_point(character))))
      result += shown_character(character);
    else
      result += character;
    text.remove_prefix(character.size());
  }
  return result;
}

}  // namespace cousin
