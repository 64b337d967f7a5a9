#include "sim/geometry/mesh_words.h"

#include <charconv>
#include <cmath>
#include <stdexcept>

#include "sim/types/utf8.h"

namespace cousin::geometry {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

}  // namespace

std::size_t MeshWords::joint() const {
  if (!joins_lines_ || at_ >= text_.size() || text_[at_] != '\\') return 0;
  const std::string_view rest = text_.substr(at_ + 1, 2);
  if (rest.starts_with('\n')) return 2;
  return rest == "\r\n" ? 3 : 0;
}

void MeshWords::skip_blanks(bool lines_too) {
  while (at_ < text_.size()) {
    if (const std::size_t bytes = joint(); bytes > 0) {
      at_ += bytes;
      ++line_;
    } else if (is_blank(text_[at_]) || (lines_too && text_[at_] == '\n')) {
      line_ += text_[at_++] == '\n';
    } else {
      return;
    }
  }
}

std::string_view MeshWords::next() {
  skip_blanks(true);
  return next_on_line();
}

std::string_view MeshWords::next_on_line() {
  skip_blanks(false);
  const std::size_t start = at_;
  while (at_ < text_.size() && !is_blank(text_[at_]) && text_[at_] != '\n' && joint() == 0) ++at_;
  return text_.substr(start, at_ - start);
}

std::string_view MeshWords::rest_of_line() {
  skip_blanks(false);
  const std::size_t start = at_;
  while (at_ < text_.size() && text_[at_] != '\n') {
    const std::size_t bytes = joint();
    line_ += bytes > 0 ? 1 : 0;
    at_ += bytes > 0 ? bytes : 1;
  }
  std::string_view rest = text_.substr(start, at_ - start);
  while (!rest.empty() && is_blank(rest.back())) rest.remove_suffix(1);
  return rest;
}

double MeshWords::number(std::string_view word) const {
  double value = 0;
  const char* begin = word.data() + (word.starts_with('+') ? 1 : 0);
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (word.empty() || error != std::errc() || stop != end || !std::isfinite(value))
    fail("expected a finite number, not \"" + readable_utf8(word.substr(0, 40)) + "\"");
  return value;
}

void MeshWords::fail(const std::string& what) const {
  throw std::runtime_error(name_ + ": " + where() + ": " + what);
}

}  // namespace cousin::geometry
