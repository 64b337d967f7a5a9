#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cousin {

/// A page of vector shapes. Millimetres, x to the right and y down from the upper left corner.
struct PrintPage {
  struct Box {
    double left_mm = 0, top_mm = 0, width_mm = 0, height_mm = 0;
  };
  struct Disc {
    double x_mm = 0, y_mm = 0, radius_mm = 0;
  };
  struct Text {
    double left_mm = 0, base_mm = 0;  ///< of its base line
    double height_mm = 4;             ///< of the font
    std::string words;                ///< printable ASCII
  };
  double width_mm = 210, height_mm = 297;
  std::vector<Box> boxes;   ///< black
  std::vector<Disc> discs;  ///< black
  std::vector<Text> texts;  ///< Helvetica
};

/// A PDF file that viewers print at its own size: no scaling is asked of them. The same bytes for
/// the same pages. Shapes of a page are one path, so that no seam shows between neighbours.
/// @throws std::invalid_argument for text that is not printable ASCII
std::string to_pdf(const std::vector<PrintPage>& pages);

/// A page as an SVG file of its own size. @throws as to_pdf
std::string to_svg(const PrintPage& page);

/// Whether a file is one of these. @param extension  ".pdf" or ".svg"
bool is_page_file(std::string_view bytes, std::string_view extension);

}  // namespace cousin
