#include "benchmarks/seeds/seeds_report.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "benchmarks/report/report.h"
#include "benchmarks/seeds/score_seeds.h"
#include "benchmarks/seeds/truth_stages.h"
#include "sim/dataset/atomic_file.h"
#include "sim/imaging/image_io.h"

namespace cousin {
namespace {

const std::vector<std::string> kTraits = {"length", "width", "height", "area", "volume"};

Image<Rgb8> crop(const Image<Rgb8>& image, int x0, int y0, int x1, int y1) {
  x0 = std::clamp(x0, 0, image.width() - 1);
  y0 = std::clamp(y0, 0, image.height() - 1);
  x1 = std::clamp(x1, x0 + 1, image.width());
  y1 = std::clamp(y1, y0 + 1, image.height());
  Image<Rgb8> result(x1 - x0, y1 - y0);
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) result(x - x0, y - y0) = image(x, y);
  }
  return result;
}

Image<Rgb8> enlarged(const Image<Rgb8>& image, int factor) {
  Image<Rgb8> result(image.width() * factor, image.height() * factor);
  for (int y = 0; y < result.height(); ++y) {
    for (int x = 0; x < result.width(); ++x) result(x, y) = image(x / factor, y / factor);
  }
  return result;
}

/// The view's image about its outlines, enlarged, with the outlines drawn in.
Image<Rgb8> with_outlines(const Image<Rgb8>& image,
                          const std::vector<const Silhouette*>& silhouettes) {
  float left = 1e9F, top = 1e9F, right = -1e9F, bottom = -1e9F;
  for (const Silhouette* s : silhouettes) {
    for (const OutlinePoint& p : s->outline) {
      left = std::min(left, p.pixel_px.x());
      right = std::max(right, p.pixel_px.x());
      top = std::min(top, p.pixel_px.y());
      bottom = std::max(bottom, p.pixel_px.y());
    }
  }
  constexpr int kMargin = 12, kZoom = 3;
  const int x0 = std::max(0, static_cast<int>(left) - kMargin),
            y0 = std::max(0, static_cast<int>(top) - kMargin);
  Image<Rgb8> picture = enlarged(
      crop(image, x0, y0, static_cast<int>(right) + kMargin, static_cast<int>(bottom) + kMargin),
      kZoom);
  for (const Silhouette* s : silhouettes) {
    for (std::size_t i = 0; i < s->outline.size(); ++i) {
      const Eigen::Vector2f a = s->outline[i].pixel_px,
                            b = s->outline[(i + 1) % s->outline.size()].pixel_px;
      const Rgb8 color = s->outline[i].on_object ? Rgb8{255, 0, 160} : Rgb8{0, 200, 255};
      for (int k = 0; k < 12; ++k) {
        const Eigen::Vector2f p = a + (b - a) * (static_cast<float>(k) / 12);
        const int x =
            static_cast<int>(std::lround((p.x() - static_cast<float>(x0) + 0.5F) * kZoom - 0.5F));
        const int y =
            static_cast<int>(std::lround((p.y() - static_cast<float>(y0) + 0.5F) * kZoom - 0.5F));
        if (picture.contains(x, y)) picture(x, y) = color;
      }
    }
  }
  return picture;
}

ReportShape shape_of(const std::vector<Mesh>& meshes, const std::string& name,
                     const std::string& caption, Rgb8 color) {
  ReportShape shape;
  shape.name = name;
  shape.caption = caption;
  for (const Mesh& mesh : meshes) {
    const auto offset = static_cast<std::uint32_t>(shape.positions_m.size());
    for (const Eigen::Vector3d& v : mesh.vertices_m) shape.positions_m.push_back(v.cast<float>());
    for (const auto& t : mesh.triangles)
      shape.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
  shape.colors.assign(shape.positions_m.size(), color);
  return shape;
}

std::string unit_of(const std::string& trait) {
  return trait == "area" ? "m2" : trait == "volume" ? "m3" : "m";
}

/// The limits that the project holds itself to.
std::string limit_text(const std::string& trait, const std::string& group) {
  if (trait == "area") return "at most 4 %";
  if (trait == "volume") return "at most 5 %";
  return group == "maize" || group == "zhengdan958" || group == "tianguinuo932" ? "at most 0.15 mm"
                                                                                : "at most 0.08 mm";
}

double limit_value(const std::string& trait, const std::string& group) {
  if (trait == "area") return 0.04;
  if (trait == "volume") return 0.05;
  return limit_text(trait, group) == "at most 0.15 mm" ? 0.00015 : 0.00008;
}

std::vector<Headline> headlines_of(const std::vector<ScoreRow>& rows) {
  std::vector<Headline> result;
  for (const ScoreRow& row : rows) {
    if (row.scene != "pooled" || row.method != "ours") continue;
    for (const std::string& trait : kTraits) {
      const bool by_size = trait == "area" || trait == "volume";
      if (row.metric != trait + (by_size ? ".mape" : ".rmse")) continue;
      if (species_of(row.case_name) == row.case_name && row.case_name != "maize" &&
          row.case_name != "wheat" && row.case_name != "rice") {
        continue;  // one line a cultivar or species is enough; "all" mixes limits
      }
      Headline headline;
      headline.label = (by_size ? "MAPE of " : "RMSE of ") + trait + ", " + row.case_name;
      headline.value = {row.value, row.ci_low, row.ci_high};
      headline.unit = by_size ? "%" : "m";
      headline.limit = limit_text(trait, row.case_name);
      headline.status =
          row.value <= limit_value(trait, row.case_name) ? ScoreStatus::pass : ScoreStatus::fail;
      result.push_back(std::move(headline));
    }
  }
  return result;
}

std::vector<ErrorTimeCurve> curves_of(const std::vector<ScoreRow>& rows) {
  std::map<std::string, ErrorTimeCurve> curves;
  for (const ScoreRow& row : rows) {
    for (const std::string& trait : kTraits) {
      if (row.metric != "curve." + trait + ".rmse" || !(row.wall_s > 0)) continue;
      ErrorTimeCurve& curve = curves[trait + "/" + row.scene];
      curve.title = "Error against time: " + trait + ", " + row.scene;
      curve.metric = "RMSE of " + trait;
      curve.unit = unit_of(trait);
      std::string setting = row.case_name;
      const std::size_t run = setting.find(" run ");
      if (run != std::string::npos) setting = setting.substr(setting.find(' ', run + 5) + 1);
      curve.points.push_back(
          {row.method, setting, row.wall_s, {row.value, row.ci_low, row.ci_high}});
    }
  }
  std::vector<ErrorTimeCurve> result;
  for (auto& [key, curve] : curves) {
    if (curve.points.size() > 2) result.push_back(std::move(curve));
  }
  return result;
}

std::vector<Attribution> attributions_of(const std::vector<ScoreRow>& rows) {
  std::map<std::string, Attribution> found;
  const std::string prefix = "truth up to ";
  for (const ScoreRow& row : rows) {
    if (!row.case_name.starts_with(prefix)) continue;
    for (const std::string& trait : kTraits) {
      if (row.metric != trait + ".rmse") continue;
      Attribution& attribution = found[row.scene + "/" + trait];
      attribution.title = "Where the error of " + trait + " comes from, " + row.scene;
      attribution.metric = "RMSE of " + trait;
      attribution.unit = row.unit;
      attribution.steps.push_back(
          {row.case_name.substr(prefix.size()), {row.value, row.ci_low, row.ci_high}});
    }
  }
  std::vector<Attribution> result;
  for (auto& [key, attribution] : found) result.push_back(std::move(attribution));
  return result;
}

}  // namespace

void add_pictures(SeedsReport& report, const SimulatedRun& run, const SeedsEstimate& estimate) {
  const auto& frames = run.capture.frames;
  const std::size_t count = frames.size();
  for (const std::size_t i : {count / 6, count / 2, 5 * count / 6}) {
    if (i >= count) continue;
    report.pictures.push_back({"View " + std::to_string(frames[i].id), "as the phone hands it over",
                               frames[i].sensors[0].color});
  }
  std::map<int, std::vector<const Silhouette*>> by_frame;
  for (const Silhouette& s : estimate.silhouettes) {
    if (!s.outline.empty()) by_frame[s.frame].push_back(&s);
  }
  for (const std::size_t i : {count / 6, 5 * count / 6}) {
    if (i >= count || !by_frame.contains(frames[i].id)) continue;
    report.pictures.push_back({"Outlines found in view " + std::to_string(frames[i].id),
                               "magenta; blue where something else cuts them; 3 times enlarged",
                               with_outlines(frames[i].sensors[0].color, by_frame[frames[i].id])});
  }
  report.cloud = estimate.cloud;
  for (const Surface& surface : estimate.surfaces) {
    if (!surface.mesh.triangles.empty()) report.measured.push_back(surface.mesh);
  }
  for (const Instance* object : specimens_of(run.truth.scene)) {
    report.truth.push_back(mesh_in_world(run.truth.scene, *object));
  }
}

void write_report(const std::filesystem::path& file, const SeedsReport& report) {
  ReportInput input;
  input.title = report.title;
  input.summary =
      "Every number here is measured against the exact shape of the specimens. Intervals are 95 % "
      "bootstrap intervals, "
      "drawn by run where there are several runs. The scene and the sensor are verified against "
      "theory only; no real "
      "device has been compared with them.";
  if (!report.command_line.empty()) input.commands = {report.command_line};
  input.config_toml = report.config_toml;
  input.scores = report.scores;
  for (const SpecimenRow& row : report.scores.specimens) {
    if (row.cultivar != kSphere) input.not_plotted = {kSphere};
  }
  input.headlines = headlines_of(report.scores.scores);
  for (const ReportPicture& picture : report.pictures) {
    input.images.push_back({picture.name, picture.caption, encode_png(picture.image)});
  }
  if (!report.cloud.empty()) {
    ReportShape shape;
    shape.name = "Cloud";
    shape.caption = "Points of the multi-view stereo: " + std::to_string(report.cloud.size()) + ".";
    for (const CloudPoint& p : report.cloud) {
      shape.positions_m.push_back(p.position_m);
      shape.colors.push_back(p.color);
    }
    input.shapes.push_back(std::move(shape));
  }
  if (!report.measured.empty()) {
    input.shapes.push_back(shape_of(report.measured, "Measured surfaces",
                                    "Closed surfaces fitted by our method", {214, 140, 60}));
  }
  if (!report.truth.empty()) {
    input.shapes.push_back(
        shape_of(report.truth, "True surfaces", "The specimens as they are", {90, 140, 200}));
  }
  input.curves = curves_of(report.scores.scores);
  input.attributions = attributions_of(report.scores.scores);
  for (const ScoreRow& row : report.scores.scores) {
    const bool of_one_run = row.metric.starts_with("seconds.") &&
                            row.metric != "seconds.perceive" && row.metric != "seconds.run" &&
                            row.suite == "run" && row.scene == "000000";
    if (of_one_run)
      input.timings.push_back({row.metric.substr(8), row.wall_s, row.cpu_s, row.peak_rss_mb});
  }
  if (!report.plan.empty()) input.notes.push_back("Plan:\n" + report.plan);
  write_file(file, make_report(input));
}

}  // namespace cousin
