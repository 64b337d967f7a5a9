#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/physics/plant_motion.h"

namespace cousin {

/// Plants at rest as text, to be kept in files: numbers with 17 digits, so that they read back bit
/// by bit.

/// Words of a text that keeps something at rest, one after another, each checked.
class RestWords {
 public:
  /// @param name  of the file, for messages
  RestWords(std::string_view text, std::string name) : text_(text), name_(std::move(name)) {}

  void expect(std::string_view words);                     ///< separated by single spaces
  bool either(std::string_view yes, std::string_view no);  ///< whether it is the first
  double number(const char* what, double low, double high);
  int integer(const char* what, int low, int high);
  void end();
  /// @throws std::runtime_error naming the file, as all of the above
  [[noreturn]] void fail(const std::string& what) const;

 private:
  std::string_view next();

  std::string_view text_;
  std::string name_;
  std::size_t at_ = 0;
};

/// "sag NUMBERS", then each stem's sections and angles.
std::string sag_text(const SagResult& sag);
/// @param nodes  of each stem that there must be  @param most_overlap_m  that it may say
/// @return its status is ok
SagResult read_sag(RestWords& words, const std::vector<int>& nodes, double most_overlap_m);

}  // namespace cousin
