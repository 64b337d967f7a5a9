#include <cstdio>

#include "benchmarks/tools/print_board/page.h"
#include "benchmarks/tools/print_board/page_text.h"

namespace cousin {
namespace {

std::string mm(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6f", value);
  return text;
}

std::string escaped(const std::string& words) {
  std::string text;
  for (const char c : checked_text(words)) {
    if (c == '<')
      text += "&lt;";
    else if (c == '>')
      text += "&gt;";
    else if (c == '&')
      text += "&amp;";
    else
      text += c;
  }
  return text;
}

}  // namespace

std::string to_svg(const PrintPage& page) {
  std::string file = std::string(kSvgHead) + "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" +
                     mm(page.width_mm) + "mm\" height=\"" + mm(page.height_mm) +
                     "mm\" viewBox=\"0 0 " + mm(page.width_mm) + " " + mm(page.height_mm) +
                     "\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n<path d=\"";
  for (const PrintPage::Box& box : page.boxes)
    file += "M" + mm(box.left_mm) + " " + mm(box.top_mm) + "h" + mm(box.width_mm) + "v" +
            mm(box.height_mm) + "h" + mm(-box.width_mm) + "z\n";
  file += "\"/>\n";
  for (const PrintPage::Disc& disc : page.discs)
    file += "<circle cx=\"" + mm(disc.x_mm) + "\" cy=\"" + mm(disc.y_mm) + "\" r=\"" +
            mm(disc.radius_mm) + "\"/>\n";
  for (const PrintPage::Text& text : page.texts)
    file += "<text x=\"" + mm(text.left_mm) + "\" y=\"" + mm(text.base_mm) +
            "\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"" + mm(text.height_mm) +
            "\">" + escaped(text.words) + "</text>\n";
  return file + "</svg>\n";
}

}  // namespace cousin
