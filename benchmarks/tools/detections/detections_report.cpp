#include "benchmarks/tools/detections/detections_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <utility>

#include "benchmarks/report/pictures.h"
#include "sim/imaging/image_io.h"

namespace cousin {
namespace {

constexpr std::size_t kPictures = 20;
constexpr std::size_t kMostMissed = 2000;
constexpr int kLargestSide_px = 900;
constexpr int kJpegQuality = 85;

constexpr Rgb8 kRight{40, 200, 60}, kMissed{230, 30, 30}, kOther{170, 60, 230},
    kNothing{255, 150, 0};

/// A frame of `width` pixels along the inner side of a box.
void draw_box(const PictureBox& box, Rgb8 color, int width, Image<Rgb8>& image) {
  const int left = static_cast<int>(std::lround(box.x)), top = static_cast<int>(std::lround(box.y));
  const int right = static_cast<int>(std::lround(box.x + box.width));
  const int bottom = static_cast<int>(std::lround(box.y + box.height));
  for (int y = std::max(top, 0); y < std::min(bottom, image.height()); ++y) {
    for (int x = std::max(left, 0); x < std::min(right, image.width()); ++x) {
      const int from_edge = std::min({x - left, right - 1 - x, y - top, bottom - 1 - y});
      if (from_edge < width) image(x, y) = color;
    }
  }
}

PictureBox scaled(const PictureBox& box, double factor) {
  return {box.x * factor, box.y * factor, box.width * factor, box.height * factor};
}

ReportImage picture_of(const TruePicture& picture, const std::vector<FoundObject>& found,
                       const PictureOutcome& outcome) {
  Image<Rgb8> image = shrunk(read_color(picture.file), kLargestSide_px);
  const double factor = static_cast<double>(image.width()) / picture.width_px;
  std::size_t missed = 0, other = 0, nothing = 0, right = 0;
  for (std::size_t o = 0; o < picture.objects.size(); ++o) {
    if (outcome.detection_of[o] >= 0) continue;
    draw_box(scaled(picture.objects[o].box, factor), kMissed, 2, image);
    ++missed;
  }
  for (std::size_t d = 0; d < outcome.found.size(); ++d) {
    const bool is_right = outcome.is_right[d] != 0, is_there = outcome.object_of[d] >= 0;
    ++(is_right ? right : is_there ? other : nothing);
    draw_box(scaled(found[outcome.found[d]].box, factor),
             is_right   ? kRight
             : is_there ? kOther
                        : kNothing,
             2, image);
  }
  char caption[200];
  std::snprintf(caption, sizeof caption,
                "%zu right (green), %zu missed (red), %zu of another class (violet), %zu where "
                "nothing is (orange)",
                right, missed, other, nothing);
  return {picture.name, caption, encode_jpeg(image, kJpegQuality)};
}

/// Places of pictures with errors, the most first.
std::vector<std::size_t> worst(const DetectionScores& detections) {
  std::vector<std::size_t> places(detections.outcomes.size());
  std::iota(places.begin(), places.end(), std::size_t{0});
  std::stable_sort(places.begin(), places.end(), [&](std::size_t a, std::size_t b) {
    return detections.outcomes[a].errors() > detections.outcomes[b].errors();
  });
  std::erase_if(places, [&](std::size_t p) { return detections.outcomes[p].errors() == 0; });
  if (places.size() > kPictures) places.resize(kPictures);
  return places;
}

std::string share(double value) { return table_cell(value, 100, 1); }

ReportTable table_of(const char* title, const std::vector<ScoreRow>& rows,
                     const std::vector<std::string>& metrics) {
  const auto is_wanted = [&](const std::string& metric) {
    return std::any_of(metrics.begin(), metrics.end(), [&](const std::string& wanted) {
      return metric == wanted || metric.starts_with(wanted + ".");
    });
  };
  ReportTable table;
  table.title = title;
  table.caption = "per cent, with 95 % intervals over plants";
  table.columns = {"of", "metric", "%", "from", "to", "objects"};
  for (const ScoreRow& row : rows) {
    if (!is_wanted(row.metric)) continue;
    table.lines.push_back({row.case_name, row.metric, share(row.value), share(row.ci_low),
                           share(row.ci_high), std::to_string(row.n)});
  }
  return table;
}

ReportTable confusion_of(const std::vector<ScoreRow>& rows) {
  ReportTable table;
  table.title = "What objects were found as";
  table.columns = {"object", "number"};
  for (const ScoreRow& row : rows) {
    if (row.metric == "confusion" && row.value > 0)
      table.lines.push_back({row.case_name, std::to_string(row.n)});
  }
  return table;
}

ReportTable missed_of(const TruePictures& truth, const DetectionScores& detections) {
  ReportTable table;
  table.title = kMissedTitle;
  table.columns = {"picture", "object", "class",    "visible %",
                   "x px",    "y px",   "width px", "height px"};
  std::size_t more = 0;
  for (const PictureOutcome& outcome : detections.outcomes) {
    const TruePicture& picture = truth.pictures[outcome.picture];
    for (std::size_t o = 0; o < picture.objects.size(); ++o) {
      if (outcome.detection_of[o] >= 0) continue;
      const TrueObject& object = picture.objects[o];
      if (table.lines.size() == kMostMissed) {
        ++more;
        continue;
      }
      table.lines.push_back(
          {picture.name, object.name, object.category,
           std::isnan(object.visible_fraction) ? "" : share(object.visible_fraction),
           table_cell(object.box.x, 1, 0), table_cell(object.box.y, 1, 0),
           table_cell(object.box.width, 1, 0), table_cell(object.box.height, 1, 0)});
    }
  }
  if (more > 0) table.caption = std::to_string(more) + " more are not listed";
  return table;
}

const ScoreRow* row_of(const std::vector<ScoreRow>& rows, const std::string& case_name,
                       const std::string& metric) {
  for (const ScoreRow& row : rows) {
    if (row.case_name == case_name && row.metric == metric) return &row;
  }
  return nullptr;
}

std::string verdict(const TruePictures& truth, const DetectionScores& detections,
                    const DetectionScoreConfig& config) {
  std::size_t objects = 0, missed = 0, wrong = 0;
  for (const PictureOutcome& outcome : detections.outcomes) {
    objects += outcome.detection_of.size();
    missed += static_cast<std::size_t>(
        std::count(outcome.detection_of.begin(), outcome.detection_of.end(), -1));
    wrong += static_cast<std::size_t>(
        std::count(outcome.object_of.begin(), outcome.object_of.end(), -1));
  }
  char text[300];
  std::snprintf(text, sizeof text,
                "%zu of %zu objects in %zu pictures were found at a confidence of %g and an "
                "overlap of %g, whatever their class; %zu detections show nothing.",
                objects - missed, objects, truth.pictures.size(), config.confidence, config.overlap,
                wrong);
  std::string all = text;
  if (const ScoreRow* row = row_of(detections.rows, "mean of classes", "AP50_95")) {
    std::snprintf(text, sizeof text, " AP50-95 is %.1f %% (%.1f to %.1f).", 100 * row->value,
                  100 * row->ci_low, 100 * row->ci_high);
    if (!std::isnan(row->value)) all += text;
  }
  return all;
}

}  // namespace

ReportInput detections_report(const TruePictures& truth, const FoundFile& found,
                              const DetectionScores& detections, const DetectionScoreConfig& config,
                              ScoreFile scores) {
  ReportInput report;
  report.title = "Cousin: detections";
  report.summary = verdict(truth, detections, config);
  for (const char* metric : {"AP50", "AP50_95"}) {
    if (const ScoreRow* row = row_of(detections.rows, "mean of classes", metric))
      report.headlines.push_back({std::string(metric) + ", mean of classes",
                                  {row->value, row->ci_low, row->ci_high},
                                  "%",
                                  "",
                                  row->status,
                                  "boxes"});
  }
  for (const char* metric : {"precision", "recall", "f1"}) {
    if (const ScoreRow* row = row_of(detections.rows, "all classes", metric))
      report.headlines.push_back(
          {metric, {row->value, row->ci_low, row->ci_high}, "%", "", row->status, "boxes"});
  }
  report.tables.push_back(table_of("Boxes", detections.rows,
                                   {"AP50", "AP75", "AP50_95", "precision", "f1", "f1_best"}));
  if (found.has_masks)
    report.tables.push_back(
        table_of("Masks", detections.rows, {"mask_AP50", "mask_AP75", "mask_AP50_95"}));
  report.tables.push_back(table_of("Recall", detections.rows, {"recall"}));
  report.tables.push_back(confusion_of(detections.rows));
  report.tables.push_back(missed_of(truth, detections));
  for (const std::size_t place : worst(detections)) {
    const auto of = found.of_picture.find(place);
    report.images.push_back(
        picture_of(truth.pictures[place],
                   of == found.of_picture.end() ? std::vector<FoundObject>{} : of->second,
                   detections.outcomes[place]));
  }
  report.scores = std::move(scores);
  return report;
}

}  // namespace cousin
