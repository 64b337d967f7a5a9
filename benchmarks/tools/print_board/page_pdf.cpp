#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "benchmarks/tools/print_board/page.h"
#include "benchmarks/tools/print_board/page_text.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

constexpr double kPointsPerMm = 72 / 25.4;
constexpr int kArcs = 8;  ///< of a disc: within 1e-5 of its radius

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.5f", value);
  return text;
}

/// Points of a PDF page: y goes up from the lower left corner.
struct PageSpace {
  double height_mm;
  std::string at(double x_mm, double y_mm) const {
    return number(x_mm * kPointsPerMm) + " " + number((height_mm - y_mm) * kPointsPerMm);
  }
};

std::string path_of(const PrintPage::Box& box, const PageSpace& space) {
  return space.at(box.left_mm, box.top_mm + box.height_mm) + " " +
         number(box.width_mm * kPointsPerMm) + " " + number(box.height_mm * kPointsPerMm) + " re\n";
}

/// Arcs as cubic curves [Riskus 2006].
std::string path_of(const PrintPage::Disc& disc, const PageSpace& space) {
  const double step = 2 * kPi / kArcs, handle = 4.0 / 3 * std::tan(step / 4) * disc.radius_mm;
  const auto on = [&](int i) { return std::array{std::cos(i * step), std::sin(i * step)}; };
  const auto at = [&](const std::array<double, 2>& direction, double along_mm) {
    return space.at(disc.x_mm + disc.radius_mm * direction[0] - along_mm * direction[1],
                    disc.y_mm + disc.radius_mm * direction[1] + along_mm * direction[0]);
  };
  std::string path = at(on(0), 0) + " m\n";
  for (int i = 0; i < kArcs; ++i)
    path += at(on(i), handle) + " " + at(on(i + 1), -handle) + " " + at(on(i + 1), 0) + " c\n";
  return path + "h\n";
}

std::string content_of(const PrintPage& page) {
  const PageSpace space{page.height_mm};
  std::string path;
  for (const PrintPage::Box& box : page.boxes) path += path_of(box, space);
  for (const PrintPage::Disc& disc : page.discs) path += path_of(disc, space);
  std::string content = "0 g\n" + (path.empty() ? path : path + "f\n");
  for (const PrintPage::Text& text : page.texts) {
    std::string words;
    for (const char c : checked_text(text.words)) {
      if (c == '(' || c == ')' || c == '\\') words += '\\';
      words += c;
    }
    content += "BT /F1 " + number(text.height_mm * kPointsPerMm) + " Tf " +
               space.at(text.left_mm, text.base_mm) + " Td (" + words + ") Tj ET\n";
  }
  return content;
}

}  // namespace

bool is_page_file(std::string_view bytes, std::string_view extension) {
  return bytes.starts_with(extension == ".pdf" ? kPdfHead : kSvgHead);
}

std::string to_pdf(const std::vector<PrintPage>& pages) {
  std::vector<std::string> objects = {
      "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>", "",
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>"};
  std::string kids;
  for (const PrintPage& page : pages) {
    const std::string content = content_of(page);
    const std::size_t own = objects.size() + 1;  // objects are numbered from 1
    kids += std::to_string(own) + " 0 R ";
    objects.push_back("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 " +
                      number(page.width_mm * kPointsPerMm) + " " +
                      number(page.height_mm * kPointsPerMm) +
                      "] /Resources << /Font << /F1 3 0 R >> >> /Contents " +
                      std::to_string(own + 1) + " 0 R >>");
    objects.push_back("<< /Length " + std::to_string(content.size()) + " >>\nstream\n" + content +
                      "endstream");
  }
  objects[1] =
      "<< /Type /Pages /Kids [" + kids + "] /Count " + std::to_string(pages.size()) + " >>";
  std::string file = kPdfHead, table;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    char line[24];
    std::snprintf(line, sizeof line, "%010zu 00000 n \n", file.size());
    table += line;
    file += std::to_string(i + 1) + " 0 obj\n" + objects[i] + "\nendobj\n";
  }
  const std::string count = std::to_string(objects.size() + 1);
  return file + "xref\n0 " + count + "\n0000000000 65535 f \n" + table + "trailer << /Size " +
         count + " /Root 1 0 R >>\nstartxref\n" + std::to_string(file.size()) + "\n%%EOF\n";
}

}  // namespace cousin
