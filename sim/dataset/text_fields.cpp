#include "sim/dataset/text_fields.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>

namespace cousin {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

/// For a message: short, without bytes that a terminal would obey.
std::string shown(std::string_view word) {
  std::string text(word.substr(0, 60));
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) > 126) c = '?';
  }
  return "\"" + text + "\"";
}

std::optional<double> finite_number(std::string_view word) {
  const char* const end = word.data() + word.size();
  double value = 0;
  const auto [stop, error] =
      std::from_chars(word.data() + (word.starts_with('+') ? 1 : 0), end, value);
  if (error != std::errc{} || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

std::string exact_text(double value) {
  char buffer[32];
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, value);
  return error == std::errc{} ? std::string(buffer, end) : std::string();
}

std::string short_text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.4g", value);
  return buffer;
}

std::string exact_text(const std::vector<double>& values, std::string_view between) {
  std::string text;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) text += between;
    text += exact_text(values[i]);
  }
  return text;
}

TextLine::TextLine(std::string_view text, const std::string& name, int number)
    : text_(text), name_(&name), number_(number) {
  std::size_t at = text.find_first_not_of(kBlanks);
  while (at != std::string_view::npos) {
    const std::size_t end = text.find_first_of(kBlanks, at);
    words_.push_back(text.substr(at, end == std::string_view::npos ? end : end - at));
    at = end == std::string_view::npos ? end : text.find_first_not_of(kBlanks, end);
  }
}

void TextLine::fail(const std::string& what) const { throw std::runtime_error(where() + what); }

std::string TextLine::where() const { return *name_ + ": line " + std::to_string(number_) + ": "; }

std::string TextLine::text(std::size_t word) const {
  if (word >= words_.size()) {
    fail("has " + std::to_string(words_.size()) + " words; word " + std::to_string(word + 1) +
         " is missing");
  }
  return std::string(words_[word]);
}

std::string TextLine::rest(std::size_t word) const {
  text(word);
  const std::size_t begin = static_cast<std::size_t>(words_[word].data() - text_.data());
  const std::size_t end = static_cast<std::size_t>(words_.back().data() - text_.data());
  return std::string(text_.substr(begin, end + words_.back().size() - begin));
}

double TextLine::number(std::size_t word) const {
  const std::string given = text(word);
  const std::optional<double> value = finite_number(given);
  if (!value)
    fail("word " + std::to_string(word + 1) + " = " + shown(given) + " is not a finite number");
  return *value;
}

bool TextLine::is_number(std::size_t word) const {
  return word < words_.size() && finite_number(words_[word]).has_value();
}

bool TextLine::is_integer(std::size_t word) const {
  if (word >= words_.size()) return false;
  std::string_view digits = words_[word];
  if (digits.starts_with('-') || digits.starts_with('+')) digits.remove_prefix(1);
  return !digits.empty() && digits.find_first_not_of("0123456789") == std::string_view::npos;
}

double TextLine::number_within(std::size_t word, double most) const {
  const double value = number(word);
  if (!(std::abs(value) <= most)) {
    fail("word " + std::to_string(word + 1) + " = " + shown(text(word)) + " is outside [-" +
         exact_text(most) + ", " + exact_text(most) + "]");
  }
  return value;
}

long long TextLine::integer(std::size_t word, long long min, long long max) const {
  const std::string given = text(word);
  const char* const end = given.data() + given.size();
  long long value = 0;
  const auto [stop, error] = std::from_chars(given.data(), end, value);
  if (error != std::errc{} || stop != end || value < min || value > max) {
    fail("word " + std::to_string(word + 1) + " = " + shown(given) + " is not an integer in [" +
         std::to_string(min) + ", " + std::to_string(max) + "]");
  }
  return value;
}

TextLine TextLines::next() {
  const std::size_t newline = rest_.find('\n');
  const std::string_view line = rest_.substr(0, newline);
  rest_ = newline == std::string_view::npos ? std::string_view() : rest_.substr(newline + 1);
  return {line, *name_, ++number_};
}

std::vector<TextLine> records(std::string_view text, const std::string& name) {
  std::vector<TextLine> result;
  TextLines lines(text, name);
  while (!lines.at_end()) {
    TextLine line = lines.next();
    if (line.size() > 0 && !line.text(0).starts_with('#')) result.push_back(std::move(line));
  }
  return result;
}

}  // namespace cousin
