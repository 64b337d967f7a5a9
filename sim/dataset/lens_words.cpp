#include "sim/dataset/lens_words.h"

#include <array>
#include <cctype>

namespace cousin {
namespace {

struct Word {
  const char* text;
  LensKind kind;
};

constexpr std::array<Word, 25> kWords = {{{"none", LensKind::none},
                                          {"pinhole", LensKind::none},
                                          {"perspective", LensKind::none},
                                          {"plumb_bob", LensKind::plumb_bob},
                                          {"radtan", LensKind::plumb_bob},
                                          {"radial_tangential", LensKind::plumb_bob},
                                          {"brown", LensKind::plumb_bob},
                                          {"brown_conrady", LensKind::plumb_bob},
                                          {"opencv", LensKind::plumb_bob},
                                          {"opencv5", LensKind::plumb_bob},
                                          {"rational_polynomial", LensKind::rational},
                                          {"rational", LensKind::rational},
                                          {"opencv8", LensKind::rational},
                                          {"full_opencv", LensKind::rational},
                                          {"thin_prism", LensKind::thin_prism},
                                          {"opencv12", LensKind::thin_prism},
                                          {"inverse_brown_conrady", LensKind::not_read},
                                          {"modified_brown_conrady", LensKind::not_read},
                                          {"fisheye", LensKind::fisheye},
                                          {"equidistant", LensKind::fisheye},
                                          {"kannala_brandt", LensKind::fisheye},
                                          {"kannala_brandt4", LensKind::fisheye},
                                          {"kannala_brandt8", LensKind::fisheye},
                                          {"kb4", LensKind::fisheye},
                                          {"opencv_fisheye", LensKind::fisheye}}};

std::string letters(std::string_view word) {
  std::string result;
  for (const char c : word) {
    if (c != '_' && c != '-' && c != ' ')
      result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return result;
}

}  // namespace

std::optional<LensKind> lens_kind_of(std::string_view word) {
  constexpr std::string_view kOfRealSense = "distortion.";
  if (word.starts_with(kOfRealSense)) word.remove_prefix(kOfRealSense.size());
  const std::string given = letters(word);
  if (given.empty()) return LensKind::unsaid;
  for (const Word& known : kWords) {
    if (given == letters(known.text)) return known.kind;
  }
  return std::nullopt;
}

std::string lens_words() {
  std::string text;
  for (const Word& known : kWords) text += (text.empty() ? "" : ", ") + std::string(known.text);
  return text;
}

}  // namespace cousin
