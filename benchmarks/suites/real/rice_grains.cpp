#include "benchmarks/suites/real/rice_grains.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

#include "benchmarks/report/pictures.h"
#include "benchmarks/score/order_statistics.h"
#include "perception/segment/grains.h"
#include "scenes/seeds/cultivar.h"
#include "sim/imaging/image_io.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScene = "rice";
constexpr const char* kFolder = "images/grainpheno_rice";

void append_distribution(std::vector<ScoreRow>& rows, const std::string& case_name,
                         const std::string& method, const std::string& trait,
                         const std::vector<double>& values_m) {
  const auto n = static_cast<std::int64_t>(values_m.size());
  const double average = mean(values_m);
  double squares = 0;
  for (const double v : values_m) squares += (v - average) * (v - average);
  const double sd = n > 1 ? std::sqrt(squares / static_cast<double>(n - 1)) : ScoreRow::kNone;
  const auto add = [&](const std::string& metric, double value, const std::string& unit) {
    rows.push_back(real_row(kScene, case_name, method, trait + "." + metric, value, unit, n));
  };
  add("mean", average, "m");
  add("sd", sd, "m");
  add("cv", sd / average, "1");
  for (const int percent : {5, 25, 50, 75, 95}) {
    add("p" + std::to_string(percent), quantile(values_m, percent / 100.0), "m");
  }
}

void draw_line(Image<Rgb8>& image, const Eigen::Vector2d& a, const Eigen::Vector2d& b, Rgb8 color) {
  const int steps = static_cast<int>((b - a).norm()) + 1;
  for (int i = 0; i <= steps; ++i) {
    const Eigen::Vector2d p = a + (b - a) * i / steps;
    const int x = static_cast<int>(std::lround(p.x())), y = static_cast<int>(std::lround(p.y()));
    for (int dy = 0; dy < 2; ++dy) {
      for (int dx = 0; dx < 2; ++dx) {
        if (image.contains(x + dx, y + dy)) image(x + dx, y + dy) = color;
      }
    }
  }
}

void draw_rectangle(Image<Rgb8>& image, const Eigen::Vector2d& centre_px, double angle_rad,
                    double length_px, double width_px, Rgb8 color) {
  const Eigen::Vector2d along =
      0.5 * length_px * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
  const Eigen::Vector2d across =
      0.5 * width_px * Eigen::Vector2d(-std::sin(angle_rad), std::cos(angle_rad));
  const std::array<Eigen::Vector2d, 4> corners = {
      centre_px + along + across, centre_px + along - across, centre_px - along - across,
      centre_px - along + across};
  for (std::size_t i = 0; i < 4; ++i) draw_line(image, corners[i], corners[(i + 1) % 4], color);
}

Image<Rgb8> overlay(Image<Rgb8> image, const GrainPhoto& photo) {
  for (const Grain& g : photo.grains) {
    draw_rectangle(image, g.centre_px, g.angle_rad, g.length_m / photo.m_per_px,
                   g.width_m / photo.m_per_px, {0, 255, 0});
  }
  for (const Strip& s : photo.strips) {
    draw_rectangle(image, s.centre_px, s.angle_rad, s.length_px, s.width_px, {0, 80, 255});
  }
  for (const Eigen::Vector2d& c : photo.touching_px)
    draw_rectangle(image, c, 0.785, 40, 40, {255, 0, 0});
  for (const Eigen::Vector2d& c : photo.other_px)
    draw_rectangle(image, c, 0, 40, 40, {255, 0, 255});
  return image;
}

/// The part of a photograph that holds grains and strips, and a little around them.
Image<Rgb8> about_marks(const Image<Rgb8>& marked, const GrainPhoto& photo) {
  constexpr double kMargin_px = 120;
  Eigen::AlignedBox2d box;
  for (const Grain& grain : photo.grains) box.extend(grain.centre_px);
  for (const Strip& strip : photo.strips) {
    const Eigen::Vector2d half =
        0.5 * strip.length_px *
        Eigen::Vector2d(std::cos(strip.angle_rad), std::sin(strip.angle_rad));
    box.extend(strip.centre_px + half);
    box.extend(strip.centre_px - half);
  }
  const Eigen::Vector2d low = box.min().array() - kMargin_px;
  const Eigen::Vector2d size = box.sizes().array() + 2 * kMargin_px;
  return cropped(marked, static_cast<int>(low.x()), static_cast<int>(low.y()),
                 static_cast<int>(size.x()), static_cast<int>(size.y()));
}

/// The photograph made small, and a part of it as it is.
void add_pictures(RealPart& part, const std::string& name, const Image<Rgb8>& marked,
                  const GrainPhoto& photo) {
  constexpr int kWhole_px = 1100, kPart_px = 700, kQuality = 88;
  const std::string legend =
      "Green: measured, by the rectangle of least area about the outline. Red: grains that touch, "
      "left out. Magenta: too large or cut by the border. Blue: paper strips of 100 mm.";
  part.images.push_back({"Rice, " + name, legend,
                         encode_jpeg(shrunk(about_marks(marked, photo), kWhole_px), kQuality)});
  if (photo.grains.empty()) return;
  const Eigen::Vector2d centre = photo.grains[photo.grains.size() / 2].centre_px;
  part.images.push_back(
      {"Rice, " + name + ", part of it", "The same photograph, pixel by pixel.",
       encode_jpeg(cropped(marked, static_cast<int>(centre.x()) - kPart_px / 2,
                           static_cast<int>(centre.y()) - kPart_px / 2, kPart_px, kPart_px),
                   kQuality)});
}

/// Lengths and widths of a group, for the page.
void add_sizes(RealPart& part, const std::string& name, const std::string& kind,
               const std::vector<double>& lengths_m, const std::vector<double>& widths_m) {
  if (part.distributions.empty()) {
    part.distributions = {{"Length of rice in the husk, real and of the scene", "length", "m", {}},
                          {"Width of rice in the husk, real and of the scene", "width", "m", {}}};
  }
  part.distributions[0].groups.push_back({name, kind, lengths_m});
  part.distributions[1].groups.push_back({name, kind, widths_m});
}

void measure_photo(const fs::path& file, const fs::path& out, RealPart& part) {
  const std::string name = file.stem().string();
  const Image<Rgb8> image = read_color(file);
  const StageClock clock("grains");
  const GrainPhoto photo = measure_grains(image);
  const double seconds = clock.finish().wall_s;
  const Image<Rgb8> marked = overlay(image, photo);
  write_png(out / ("rice_" + name + ".png"), marked);
  std::vector<ScoreRow>& rows = part.rows;
  if (photo.status != GrainStatus::ok) {
    rows.push_back(not_solved_row(kScene, name,
                                  photo.status == GrainStatus::no_strip
                                      ? "no paper strip is seen"
                                      : "no single grain is seen"));
    return;
  }
  add_pictures(part, name, marked, photo);
  const auto add = [&](const std::string& metric, double value, const std::string& unit,
                       std::size_t n) {
    rows.push_back(
        real_row(kScene, name, "photograph", metric, value, unit, static_cast<std::int64_t>(n)));
  };
  const std::size_t strips = photo.strips.size(), grains = photo.grains.size();
  add("scale_per_px", photo.m_per_px, "m", strips);
  add("scale_over_file_density", photo.m_per_px / stated_m_per_px(file), "1", strips);
  add("shortest_strip_over_longest", photo.strips.back().length_px / photo.strips.front().length_px,
      "1", strips);
  add("grains_measured", static_cast<double>(grains), "1", grains);
  add("blobs_of_touching_grains", static_cast<double>(photo.touching_px.size()), "1",
      photo.touching_px.size());
  std::vector<double> lengths_m, widths_m;
  for (const Grain& grain : photo.grains) {
    lengths_m.push_back(grain.length_m);
    widths_m.push_back(grain.width_m);
  }
  append_distribution(rows, name, "photograph", "length", lengths_m);
  append_distribution(rows, name, "photograph", "width", widths_m);
  add("seconds.measure", seconds, "s", grains);
  add_sizes(part, name, "photographed", lengths_m, widths_m);
}

/// Sizes as make_seed draws them; its bodies are fitted to them within 0.1 %.
void draw_scene_sizes(const std::string& cultivar_name, int seeds, RealPart& part) {
  std::vector<double> lengths_m, widths_m;
  for (int i = 0; i < seeds; ++i) {
    Rng rng = Rng(1).fork(cultivar_name).fork(static_cast<std::uint64_t>(i));
    const Eigen::Vector3d size_m =
        draw_size_m(cultivar(cultivar_name), SizeSpread::literature, rng);
    lengths_m.push_back(size_m.x());
    widths_m.push_back(size_m.y());
  }
  append_distribution(part.rows, cultivar_name, "scene", "length", lengths_m);
  append_distribution(part.rows, cultivar_name, "scene", "width", widths_m);
  add_sizes(part, cultivar_name, "scene", lengths_m, widths_m);
}

}  // namespace

double stated_m_per_px(const fs::path& jpeg) {
  // FF D8, FF E0, length, "JFIF\0", version, unit (1 = inch, 2 = cm), x and y density, big-endian
  // [ITU-T T.871].
  std::array<unsigned char, 18> head{};
  std::ifstream stream(jpeg, std::ios::binary);
  stream.read(reinterpret_cast<char*>(head.data()), head.size());
  constexpr std::array<unsigned char, 5> kName = {'J', 'F', 'I', 'F', 0};
  if (!stream || head[3] != 0xE0 || !std::equal(kName.begin(), kName.end(), head.begin() + 6))
    return ScoreRow::kNone;
  const double density = head[14] * 256 + head[15];
  if (density <= 0 || head[13] < 1 || head[13] > 2) return ScoreRow::kNone;
  return (head[13] == 1 ? 0.0254 : 0.01) / density;
}

RealPart rice_grains(const fs::path& real_data, const fs::path& out, bool quick) {
  RealPart part;
  for (const char* name :
       {"Test1_100mm_ruler.jpg", "Test3_100mm_ruler.jpg", "Test5_100mm_ruler.jpg"}) {
    const fs::path file = real_data / kFolder / name;
    if (!fs::exists(file)) {
      part.rows.push_back(
          not_solved_row(kScene, fs::path(name).stem().string(), "the photograph is absent"));
      continue;
    }
    measure_photo(file, out, part);
  }
  for (const char* name : {"suijing18", "xiangyaxiangzhan"})
    draw_scene_sizes(name, quick ? 300 : 3000, part);
  return part;
}

}  // namespace cousin
