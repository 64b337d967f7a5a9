#include "scenes/seeds/seed_parts.h"

#include <cmath>

namespace cousin {
namespace {

enum Maize : std::uint16_t { kMaizeBody, kTipCap, kMaizeEmbryo, kDent };
enum Wheat : std::uint16_t { kWheatBody, kCrease, kWheatEmbryo, kBrush };
enum Rice : std::uint16_t { kLemma, kPalea, kSterileLemmas, kPedicel, kApiculus };

/// `groove` is the shield over the embryo, `relief` the crown's dent.
Maize maize_part(const SeedSkinPoint& s) {
  if (s.along < 0.105) return kTipCap;  // up to the neck
  if (s.groove > 0.5) return kMaizeEmbryo;
  return s.relief > 0.5 ? kDent : kMaizeBody;
}

Wheat wheat_part(const SeedSkinPoint& s) {
  if (s.groove > 0.25) return kCrease;  // its flanks too
  if (s.relief > 0.5) return kWheatEmbryo;
  return s.along > 0.97 ? kBrush : kWheatBody;  // where its colour begins to prevail
}

Rice rice_part(const SeedSkinPoint& s) {
  if (s.along < 0.0175) return kPedicel;
  if (s.along > 0.9825) return kApiculus;
  if (s.along < 0.205 - 0.10 * s.across * s.across) return kSterileLemmas;
  return std::atan2(std::abs(s.up), s.across) > rice_seam_rad(s.along) ? kPalea : kLemma;
}

std::uint16_t part_of(const SeedSkinPoint& s, Species species) {
  switch (species) {
    case Species::maize:
      return maize_part(s);
    case Species::wheat:
      return wheat_part(s);
    case Species::rice:
      return rice_part(s);
  }
  return 0;
}

}  // namespace

const std::vector<std::string>& seed_part_names(Species species) {
  static const std::vector<std::string> maize = {"body", "tip_cap", "embryo", "dent"};
  static const std::vector<std::string> wheat = {"body", "crease", "embryo", "brush"};
  static const std::vector<std::string> rice = {"lemma", "palea", "sterile_lemmas", "pedicel",
                                                "apiculus"};
  switch (species) {
    case Species::maize:
      return maize;
    case Species::wheat:
      return wheat;
    case Species::rice:
      break;
  }
  return rice;
}

std::vector<std::uint16_t> seed_parts(const SeedShape& shape, Species species) {
  std::vector<std::uint16_t> parts;
  parts.reserve(shape.mesh.triangles.size());
  for (const auto& triangle : shape.mesh.triangles) {
    SeedSkinPoint middle;
    for (const std::uint32_t i : triangle) {
      const SeedSkinPoint& s = shape.surface[i];
      middle.along += s.along / 3;
      middle.across += s.across / 3;
      middle.up += s.up / 3;
      middle.groove += s.groove / 3;
      middle.relief += s.relief / 3;
    }
    parts.push_back(part_of(middle, species));
  }
  return parts;
}

}  // namespace cousin
