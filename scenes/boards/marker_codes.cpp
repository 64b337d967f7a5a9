#include "scenes/boards/marker_codes.h"

#include <algorithm>
#include <array>
#include <opencv2/aruco/dictionary.hpp>
#include <stdexcept>
#include <string_view>

namespace cousin {
namespace {

/// In the order of cv::aruco::PREDEFINED_DICTIONARY_NAME.
constexpr std::array<std::string_view, 21> kDictionaries = {
    "DICT_4X4_50",         "DICT_4X4_100",       "DICT_4X4_250",       "DICT_4X4_1000",
    "DICT_5X5_50",         "DICT_5X5_100",       "DICT_5X5_250",       "DICT_5X5_1000",
    "DICT_6X6_50",         "DICT_6X6_100",       "DICT_6X6_250",       "DICT_6X6_1000",
    "DICT_7X7_50",         "DICT_7X7_100",       "DICT_7X7_250",       "DICT_7X7_1000",
    "DICT_ARUCO_ORIGINAL", "DICT_APRILTAG_16h5", "DICT_APRILTAG_25h9", "DICT_APRILTAG_36h10",
    "DICT_APRILTAG_36h11"};

}  // namespace

std::vector<MarkerCode> marker_codes(const std::string& dictionary, int count) {
  const auto found = std::find(kDictionaries.begin(), kDictionaries.end(), dictionary);
  if (found == kDictionaries.end()) {
    std::string names;
    for (const std::string_view name : kDictionaries)
      names += (names.empty() ? "" : ", ") + std::string(name);
    throw std::invalid_argument("dictionary \"" + dictionary + "\" is not one of " + names);
  }
  const auto codes =
      cv::aruco::getPredefinedDictionary(static_cast<int>(found - kDictionaries.begin()));
  if (count > codes->bytesList.rows) {
    throw std::invalid_argument("dictionary \"" + dictionary + "\" has " +
                                std::to_string(codes->bytesList.rows) +
                                " markers; the board needs " + std::to_string(count));
  }
  std::vector<MarkerCode> result;
  for (int id = 0; id < count; ++id) {
    const cv::Mat bits = cv::aruco::Dictionary::getBitsFromByteList(
        codes->bytesList.rowRange(id, id + 1), codes->markerSize);
    MarkerCode code;
    code.bits = codes->markerSize;
    for (int row = 0; row < code.bits; ++row) {
      for (int column = 0; column < code.bits; ++column)
        code.is_white.push_back(bits.at<unsigned char>(row, column) != 0);
    }
    result.push_back(std::move(code));
  }
  return result;
}

std::vector<MarkerCode> kalibr_codes(int count) {
  std::vector<MarkerCode> codes = marker_codes("DICT_APRILTAG_36h11", count);
  for (MarkerCode& code : codes) std::reverse(code.is_white.begin(), code.is_white.end());
  return codes;
}

}  // namespace cousin
