// Pages to print, as another program draws them.
#include "benchmarks/tools/print_board/board_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <stdexcept>

#include "calibration/boards/target_detection.h"
#include "scenes/boards/boards_scene.h"
#include "sim/dataset/atomic_file.h"
#include "sim/imaging/image_io.h"
#include "sim/process/program_run.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

bool has_pdftoppm() { return fs::exists("/usr/bin/pdftoppm"); }

/// The first page as poppler draws it.
Image<Rgb8> drawn(const std::string& pdf, int dots_per_inch) {
  const TemporaryFolder folder;
  write_file(folder.path() / "page.pdf", pdf);
  const std::string stem = (folder.path() / "page").string();
  const auto run =
      run_program({.words = {"/usr/bin/pdftoppm", "-r", std::to_string(dots_per_inch), "-png", "-f",
                             "1", "-l", "1", "-singlefile", stem + ".pdf", stem},
                   .log = folder.path() / "log"});
  EXPECT_EQ(run.code, 0) << read_file(folder.path() / "log");
  return read_color(folder.path() / "page.png");
}

/// The part about the print.
Image<Rgb8> cropped(const Image<Rgb8>& page, const BoardPage& board, const Eigen::Vector2d& size_mm,
                    double dots_per_mm, Eigen::Vector2i& corner) {
  constexpr double kBeside_mm = 5;
  corner = Eigen::Vector2i(static_cast<int>((board.left_mm - kBeside_mm) * dots_per_mm),
                           static_cast<int>((board.top_mm - kBeside_mm) * dots_per_mm));
  const Eigen::Vector2d wanted = (size_mm.array() + 2 * kBeside_mm) * dots_per_mm;
  Image<Rgb8> part(static_cast<int>(wanted.x()), static_cast<int>(wanted.y()));
  for (int y = 0; y < part.height(); ++y) {
    for (int x = 0; x < part.width(); ++x) part(x, y) = page(corner.x() + x, corner.y() + y);
  }
  return part;
}

/// Largest distance of a point found from where the target has it, and how many were found.
std::pair<double, std::size_t> largest_error_mm(const std::string& name, int dots_per_inch) {
  const CalibrationTarget target = board_preset(name);
  const BoardPage board = board_page(target, name, "");
  const double dots_per_mm = dots_per_inch / 25.4;
  const Eigen::Vector2d size_mm = 1e3 * print_size_m(target);
  Eigen::Vector2i corner;
  const Image<Rgb8> part =
      cropped(drawn(to_pdf({board.page}), dots_per_inch), board, size_mm, dots_per_mm, corner);
  const TargetView view = find_target(light_of(part), target);
  EXPECT_TRUE(is_usable(view)) << name << ": " << view.reason;
  std::map<int, Eigen::Vector2d> at_m;
  for (const TargetPoint& point : target_points(target)) at_m[point.id] = point.at_m;
  double largest_mm = 0;
  for (const TargetObservation& seen : view.points) {
    const Eigen::Vector2d found_mm =
        (seen.pixel_px + corner.cast<double>() + Eigen::Vector2d::Constant(0.5)) / dots_per_mm;
    const Eigen::Vector2d& own = at_m.at(seen.id);
    const Eigen::Vector2d true_mm(board.left_mm + 0.5 * size_mm.x() + 1e3 * own.x(),
                                  board.top_mm + 0.5 * size_mm.y() - 1e3 * own.y());
    largest_mm = std::max(largest_mm, (found_mm - true_mm).norm());
  }
  return {largest_mm, view.points.size()};
}

TEST(BoardPage, PointsLieWhereTheTargetHasThemWhenAnotherProgramDrawsThePage) {
  if (!has_pdftoppm()) GTEST_SKIP() << "pdftoppm (package poppler-utils) is not installed";
  for (const char* name :
       {"chessboard_a4", "charuco_a4", "aprilgrid_a4", "circles_a4", "acircles_a4"}) {
    const auto [error_mm, count] = largest_error_mm(name, 200);
    EXPECT_EQ(count, target_points(board_preset(name)).size()) << name;
    // Poppler draws edges by four samples a pixel of 0.127 mm.
    EXPECT_LT(error_mm, 0.045) << name;
  }
}

TEST(BoardPage, TheSeedBoardAt600DotsAnInchIsWithin20Micrometres) {
  if (!has_pdftoppm()) GTEST_SKIP() << "pdftoppm (package poppler-utils) is not installed";
  const auto [error_mm, count] = largest_error_mm("seeds", 600);
  EXPECT_GT(count, 100U);
  EXPECT_LT(error_mm, 0.02);
}

TEST(BoardPage, TheRulerIsAsLongAsItSays) {
  if (!has_pdftoppm()) GTEST_SKIP() << "pdftoppm (package poppler-utils) is not installed";
  const BoardPage board = board_page(board_preset("seeds"), "seeds", "a4");
  ASSERT_EQ(board.ruler_mm, 150);
  const double dots_per_mm = 300 / 25.4;
  const Image<Rgb8> page = drawn(to_pdf({board.page}), 300);
  EXPECT_NEAR(page.width(), 210 * dots_per_mm, 1);
  // Of the lowest lines in the rows below the board, the first and the last column with ink.
  int first = page.width(), last = 0;
  const int row = static_cast<int>((297 - 5 - 14.5 + 1 + 1) * dots_per_mm);
  for (int x = 0; x < page.width(); ++x) {
    if (page(x, row).g > 128) continue;
    first = std::min(first, x);
    last = std::max(last, x);
  }
  EXPECT_NEAR((last - first) / dots_per_mm, 150, 0.2);
}

TEST(BoardPage, HasAsMuchInkAsThePrint) {
  for (const std::string& name : board_names()) {
    const CalibrationTarget target = board_preset(name);
    const BoardPage board = board_page(target, name, "");
    if (target.kind != TargetKind::chessboard) continue;
    double ink_mm2 = 0;
    for (const PrintPage::Box& box : board.page.boxes) {
      if (box.top_mm < board.top_mm + 1e3 * print_size_m(target).y())
        ink_mm2 += box.width_mm * box.height_mm;
    }
    const double square_mm2 = 1e6 * target.pitch_m * target.pitch_m;
    EXPECT_NEAR(ink_mm2 / square_mm2, (target.columns * target.rows + 1) / 2, 1e-6) << name;
  }
}

std::string refusal(const std::string& name, const std::string& paper) {
  try {
    board_page(board_preset(name), name, paper);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(BoardPage, APaperThatIsTooSmallIsRefusedWithOneThatIsNot) {
  EXPECT_THAT(refusal("charuco_a2", "a4"),
              AllOf(HasSubstr("210.0 x 297.0 mm"), HasSubstr("560.0 x 360.0 mm"),
                    HasSubstr("it fits on a2")));
  EXPECT_THAT(refusal("seeds", "b4"), HasSubstr("is not one of a5, a4"));
  EXPECT_EQ(board_page(board_preset("seeds"), "seeds", "").paper, "a5");
  for (const std::string& name : board_names()) {
    if (name.ends_with("_a4")) EXPECT_EQ(board_page(board_preset(name), name, "").paper, "a4");
  }
  CalibrationTarget huge = board_preset("chessboard_a4");
  huge.pitch_m = 0.5;
  EXPECT_THROW(board_page(huge, "huge", ""), std::invalid_argument);
}

TEST(BoardPage, FilesAreTheSameForTheSamePageAndKnownAsOurs) {
  const BoardPage board = board_page(board_preset("circles_a4"), "circles_a4", "a4");
  std::vector<PrintPage> pages = {board.page};
  for (const PrintPage& page : protocol_pages(board_preset("circles_a4"), board))
    pages.push_back(page);
  EXPECT_EQ(pages.size(), 3U);
  EXPECT_EQ(to_pdf(pages), to_pdf(pages));
  EXPECT_THAT(to_pdf(pages), AllOf(HasSubstr("/Count 3"), HasSubstr("PrintScaling /None")));
  EXPECT_TRUE(is_page_file(to_pdf(pages), ".pdf"));
  EXPECT_THAT(to_svg(board.page), AllOf(HasSubstr("width=\"297.000000mm\""), HasSubstr("<circle")));
  EXPECT_TRUE(is_page_file(to_svg(board.page), ".svg"));
  EXPECT_FALSE(is_page_file("<svg>", ".svg"));
  PrintPage page;
  page.texts = {{0, 0, 4, "\xc3\xa4"}};
  EXPECT_THROW(to_pdf({page}), std::invalid_argument);
  EXPECT_THROW(to_svg(page), std::invalid_argument);
}

TEST(BoardPage, NoTextLeavesThePage) {
  for (const char* name : {"seeds", "charuco_a4", "aprilgrid_a4"}) {
    const BoardPage board = board_page(board_preset(name), name, "");
    for (const PrintPage& page : protocol_pages(board_preset(name), board)) {
      for (const PrintPage::Text& text : page.texts) {
        EXPECT_LT(text.base_mm, page.height_mm - 5) << text.words;
        // Helvetica's letters are half their height wide, on average.
        EXPECT_LT(text.left_mm + 0.5 * text.height_mm * static_cast<double>(text.words.size()),
                  page.width_mm - 5)
            << text.words;
      }
    }
  }
}

}  // namespace
}  // namespace cousin
