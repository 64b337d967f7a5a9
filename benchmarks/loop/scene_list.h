#pragma once

#include "scenes/apples/apples_text.h"
#include "scenes/boards/boards_text.h"
#include "scenes/maize/maize_text.h"
#include "scenes/seedlings/seedlings_text.h"
#include "scenes/specimen/specimen_text.h"
#include "scenes/strawberries/strawberries_text.h"

/// Scenes of the part `scenes`, in the order of `cousin scenes`: text and row of each. To add one,
/// add its folder to COUSIN_SCENES in the root's CMakeLists.txt, and its line here.
#define COUSIN_PART_SCENES(SCENE)      \
  SCENE(kSeedlingsText, seedlings_row) \
  SCENE(kMaizeText, maize_row)         \
  SCENE(kApplesText, apples_row)       \
  SCENE(kBoardsText, boards_row)       \
  SCENE(kSpecimenText, specimen_row)   \
  SCENE(kStrawberriesText, strawberries_row)
