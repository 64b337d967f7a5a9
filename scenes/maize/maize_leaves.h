#pragma once

#include <algorithm>

#include "scenes/maize/maize_grower.h"

namespace cousin {

/// Private to scenes/maize: makes the leaves of a draft whose stalk has grown.
class LeafMaker {
 public:
  LeafMaker(MaizeDraft& draft, const LineWalk& axis);
  /// Sheath, ligule and blade on the internode `parent`.
  void add(int rank, int parent);
  bool has_collar(int rank) const;

 private:
  /// Where a blade's base, and all of it that is still rolled in the whorl, lies about the stalk.
  struct Clasp {
    double base_m = 0;    ///< of the collar, along the axis
    double radius_m = 0;  ///< of the sheath's mouth, or of the younger leaves that it wraps
    double roll_m = 0;    ///< by which it grows a radian, so that one margin lies on the other
    Eigen::Vector3d side, across;  ///< unit, across the axis: to the midrib, and to its left margin
    double out = 0;                ///< 1: it has left the whorl
  };
  /// Heights along the axis between which a blade opens from a roll about it to flat.
  struct Opening {
    double start_m = 0, end_m = 0;
  };
  double sheath_share(int rank) const;
  double sheath_m(int rank) const;
  double node_m(int rank) const;    ///< along the axis
  double collar_m(int rank) const;  ///< along the axis
  double dryness(int rank) const;
  double blade_share(int rank) const;  ///< of its length
  double blade_m(int rank) const;      ///< its length
  double out_share(int rank) const;    ///< 1: it has left the whorl
  double base_m(int rank) const;       ///< where the blade leaves the sheath or the whorl
  int last_collar() const { return static_cast<int>(std::min<double>(d_.stage, c_.plant.leaves)); }
  double steepness(double in) const;  ///< height over length of a blade in the whorl: 1, or out
  Opening opening(int rank) const;
  double funnel_at(double up_m) const;  ///< the whorl's width over that at its foot
  int leaves_inside(int rank) const;    ///< younger ones that it may wrap
  bool has_fallen(int rank) const;
  double wrapped_m(int rank, double along_m) const;
  CentreLine along_axis(int rank, double from_m, double to_m, int steps, double wider_m) const;
  void grow_sheath(Organ& organ) const;
  void grow_ligule(Organ& organ) const;
  BladeShape shape_of(int rank, double out, double length_share) const;
  void grow_blade(Organ& organ) const;
  void clasp(Organ& organ, const Clasp& clasp) const;
  void colour_blade(Organ& organ, double out, double dry) const;

  MaizeDraft& d_;
  const MaizeConfig& c_;
  const LineWalk& axis_;
  double top_collar_m_ = 0;  ///< of the highest collar, along the axis
};

}  // namespace cousin
