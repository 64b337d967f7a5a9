#pragma once

#include <string>
#include <vector>

#include "scenes/maize/maize_plant.h"

namespace cousin {

/// Private to scenes/maize: what one plant is, at whatever stage.
struct MaizeIndividual {
  double vigour = 1, azimuth_rad = 0, lean_rad = 0, lean_azimuth_rad = 0;
  struct Leaf {
    double azimuth_rad = 0, size = 1, angle = 1, droop = 1, phase_rad = 0, twist_rad = 0;
  };
  std::vector<Leaf> leaves;  ///< by rank, from 0
  std::uint64_t colour_key = 0;
};

/// The stalk at a stage: its axis from the crown up, and where the nodes are on it.
struct MaizeStalk {
  CentreLine line;              ///< up to the last node that has a length below it
  std::vector<double> nodes_m;  ///< along the line, of each leaf rank from 0
  double youth = 1;             ///< radius over the full plant's
  double surface_m = 0;         ///< along the line, where it leaves the soil
};

/// One plant being made.
struct MaizeDraft {
  const MaizeConfig& config;
  const MaizeIndividual& own;
  double stage = 0;
  MaizeStalk stalk;
  Plant plant;
};

/// Share of an organ's growth between two stages: 0 before, 1 after, fastest half-way.
double grown_share(double stage, double begin, double end);

/// Colours of the materials, of which vertices take shares: the brightest of what has the look.
Eigen::Vector3d maize_base(const MaizeConfig& config, MaizeLook look);

/// The surface of an organ that has a line, in one colour.
void finish_tube(const MaizeConfig& config, Organ& organ, int sides,
                 const std::vector<double>& albedo);

/// Prop roots from the nodes by the soil; tassel and ear: all organs, there or not.
void add_prop_roots(MaizeDraft& draft, const LineWalk& axis);
void add_tassel(MaizeDraft& draft);
void add_ear(MaizeDraft& draft, const LineWalk& axis);

}  // namespace cousin
