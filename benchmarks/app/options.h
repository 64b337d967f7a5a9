#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cousin {

/// Exit codes of the program.
enum class ExitCode { done = 0, gate_failed = 1, usage = 2, bad_input = 3, internal = 4 };

/// What the command line says; one struct for all verbs, each reads what concerns it.
struct Options {
  std::string verb;
  std::vector<std::string> arguments;  ///< positional, after the verb; a path ends with a name
  std::uint64_t seed = 1;
  int threads = 0;                ///< 0 = all cores
  std::string out;                ///< empty = the verb's default
  std::string config;             ///< TOML file read before `sets`; empty = none
  std::vector<std::string> sets;  ///< key=value
  bool json = false;
  bool quiet = false;
  int scenes = 1;
  int frames = 0;     ///< views of each scene; 0 = the scene's own number
  std::string shard;  ///< "i/n"
  std::string lpips;  ///< TorchScript file; empty = images are not scored by a network
  std::string only;   ///< part of the names of the jobs that `bench` runs; empty = all
  bool list = false;  ///< print these jobs in place of running them
  std::string ledger_file = "docs/ledger.jsonl";  ///< of `ledger`, as the next two
  std::string ledger_unit, ledger_why;
  std::string class_map;     ///< `score` of detections: "0=low,1=high"; "" = the dataset's order
  double confidence = 0.25;  ///< `score` of detections: those from here on are counted
  std::string truth_for;     ///< export format whose truth `render` writes too
  std::string truth_format = "npy";  ///< of the truth images of floats that `render` writes
  std::string truth;     ///< images that `render` writes: list of names, all or none; "" = default
  std::string streams;   ///< images of the rig that `render` writes; "" = all that it has
  std::string captures;  ///< where `bench seeds` keeps what it renders; empty = nowhere
  std::string method;
  std::string pipeline;
  std::string pipeline_config;  ///< run --pipeline scene: TOML file of the pipeline; empty = none
  std::vector<std::string> stages;  ///< NAME=dir:…|exec:…
  std::vector<std::string> gates;
  std::string format;
  std::string intrinsics;
  double depth_unit_m = 0;            ///< metres a unit of imported depth; 0 = as the format says
  double length_unit_m = 0;           ///< metres a unit of an imported calibration; 0 = likewise
  bool undistort = false;             ///< `export` makes pinhole pictures
  bool true_cameras = false;          ///< `export` takes the truth's lenses and poses
  std::string split = "0.8,0.1,0.1";  ///< shares of train, val and test
  std::string masks = "rle";
  std::string task = "detect";
  std::string category;  ///< label of specimens that sorts them; empty: the dataset's categories
  double least_visible = 0;      ///< share of an object's pixels below which labels leave it out
  std::string rig;               ///< preset, or the path of one, that `fit-sensor` starts from
  std::string ruler;             ///< what `measure` is told of the print, "99.7" or "149.6/150"
  double ruler_sigma_mm = 0.25;  ///< of that reading
  int expect = 0;                ///< seeds a sample that `measure` should measure
  std::string group;   ///< what sources are to each other, "cultivar"; empty: not compared
  std::string paper;   ///< that `board` prints on; empty = the smallest
  std::string board;   ///< target that `calibrate` looks for; empty = the dataset's
  std::string model;   ///< lens model of `calibrate`; empty = opencv5
  std::string solver;  ///< of `calibrate`; empty = ceres
  std::string fixed;   ///< parameters that `calibrate` keeps, parted by commas
  bool plan = false;
  bool align = false;  ///< `score`: the estimate's frame and unit are its own
  bool quick = false;
  int runs = 0;  ///< of each point of a benchmark; 0 = the suite's own number
  bool attribution = false;
  bool keys = false;                  ///< print configuration keys
  double memory_limit_gib = 0;        ///< of one input; 0 = the default
  double stage_time_limit_s = 21600;  ///< of each call of a stage's program
  std::vector<std::string> given;     ///< "--method", ...: options that the command line holds
};

/// Result of reading the command line: options, or text to print and leave.
struct ParsedOptions {
  Options options;
  bool leave = false;
  ExitCode code = ExitCode::done;
  std::string text;
};
ParsedOptions parse_options(int argc, const char* const* argv);

}  // namespace cousin
