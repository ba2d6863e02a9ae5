// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Numbers of how figures live in a map: metres, seconds, radians. The viewer's figures have the same in
// apps/viewer/web/src/play/rules.json; a test compares the two.
#pragma once

#include <array>

#include "panoptic/planning/recast_mesh.h"

namespace panoptic::agent_rules {

struct Range {
  double low = 0;
  double high = 0;
};

inline constexpr int kStepsPer_s = 60;
inline constexpr double kStep_s = 1.0 / kStepsPer_s;
inline constexpr int kStepsPerSample = 6;  // of where they are: ten a second
static_assert(kStepsPerSample * 10 == kStepsPer_s);
inline constexpr int kMostAgents = 32;
inline constexpr std::array kHeights_m = {1.6, 1.68, 1.55, 1.64, 1.58, 1.66};  // of their bodies, in turn

// Who keeps farther away from others never arrives beside them: 1.2 within 1.8 m is as strong as the wish to go on.
inline constexpr WalkRules kWalk = {.radius_m = 0.2,
                                    .height_m = 1.6,
                                    .acceleration_m_s2 = 5,
                                    .speed_m_s = 1.05,
                                    .looks_m = 0.8,
                                    .optimizes_m = 5,
                                    .separation = 0.6};
inline constexpr double kSlowestShare = 0.85;  // of the speed
inline constexpr double kTurn_rad_s = 3.4;
inline constexpr double kTurnWalking_rad_s = 5.5;
inline constexpr double kArrived_m = 0.07;
inline constexpr double kPatience_s = 12;  // without getting on: then it gives up
inline constexpr double kStuck_s = 0.8;
inline constexpr double kSitDown_s = 1.5;
inline constexpr double kLieDown_s = 1.7;

// Spots before a seat where one stands: so far from its middle, so far aside of where it faces; the nearest, and least aside,
// first.
inline constexpr std::array kSpotDistances_m = {0.42, 0.5, 0.6, 0.72, 0.85};
inline constexpr std::array kSpotTurns_rad = {0.0, 0.4, -0.4, 0.8, -0.8, 1.3, -1.3};
inline constexpr double kTurnCosts_m = 0.35;  // a radian
inline constexpr double kSpotOff_m = 0.09;
// Else the floor nearest to a place so far ahead of the seat.
inline constexpr double kAnySpotAhead_m = 0.4;
inline constexpr double kAnySpotOff_m = 0.8;
inline constexpr double kAnySpotFarthest_m = 0.95;  // from the seat

inline constexpr double kBedEdge_m = 0.18;   // inwards: there one sits before one lies
inline constexpr double kHeadShare = 0.035;  // of the height, from the middle of who lies to the pelvis

inline constexpr int kTries = 24;
inline constexpr double kApart_m = 0.7;  // at the beginning
inline constexpr Range kBored_s = {1.5, 4};
inline constexpr Range kRests_s = {6, 16};
inline constexpr double kSitsShare = 0.4;  // of what is decided; others walk
inline constexpr double kLiesShare = 0.12;
inline constexpr double kInTheWay_m = 0.8;
inline constexpr Range kAside_m = {1, 3};

// Insects crawl on walls from place to place, with rests.
inline constexpr Range kInsectSpeed_m_s = {0.09, 0.15};  // each has its own
inline constexpr double kInsectTurn_rad_s = 3;
inline constexpr double kInsectTurnsFirst_rad = 0.35;  // farther off its way it stands and turns
inline constexpr Range kInsectRests_s = {0.4, 2.5};
inline constexpr double kInsectFarthest_m = 2.5;  // from one place to the next
inline constexpr int kInsectTries = 8;
inline constexpr int kInsectWalls = 6;  // the largest ones have insects

}  // namespace panoptic::agent_rules
