#pragma once

#include <string>

#include "benchmarks/report/report.h"
#include "benchmarks/tools/detections/score_detections.h"

namespace cousin {

/// Title of the last table, which lists what was missed.
inline constexpr const char* kMissedTitle = "Every object that was missed";

/// The page of a file of detections: precisions and recalls, the twenty pictures with the most
/// errors, and every object that was missed. In pictures what is right is green, an object that was
/// missed red, one that was found as another class violet, and what is nothing orange.
/// @param scores  their rows, with the header
/// @throws std::runtime_error naming a picture that cannot be read
ReportInput detections_report(const TruePictures& truth, const FoundFile& found,
                              const DetectionScores& detections, const DetectionScoreConfig& config,
                              ScoreFile scores);

}  // namespace cousin
