// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Ids for users and slots for voxels, in a life longer than there are slots.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "panoptic/objects.h"
#include "tests/sanitized.h"

namespace panoptic {
namespace {

constexpr std::uint16_t kFirst = 40;

// Fills all slots, so that the next one is given anew.
void give_all_slots(ObjectRegistry& registry) {
  while (registry.find(LabelSlot{65534}) == nullptr) ASSERT_TRUE(registry.create());
}

// Users keep ids; one that was merged must never come to mean something else. Its slot may, when nothing names it any more.
TEST(ObjectRegistry, ASlotThatWasMergedAwayIsGivenAnewWhenNothingNamesItAnyMore) {
  ObjectRegistry registry(kFirst);
  const LabelSlot a = *registry.create();
  const LabelSlot b = *registry.create();
  registry.merge(a, b, 7);
  give_all_slots(registry);
  EXPECT_EQ(registry.create(), std::nullopt);
  const std::vector<bool> all(65536, true);
  std::vector<bool> all_but_a = all;
  all_but_a[number(a)] = false;

  registry.retire_unused(all);
  EXPECT_EQ(registry.create(), std::nullopt) << "a voxel holds it";
  registry.retire_unused(all_but_a, all);
  EXPECT_EQ(registry.create(), std::nullopt) << "something else names it";
  EXPECT_EQ(registry.survivor(a), b) << "as long as it is named";
  EXPECT_EQ(registry.named_by(a), PanopticId{kFirst});
  EXPECT_EQ(registry.id_of(a), PanopticId{kFirst + 1});
  registry.retire_unused(all_but_a, all_but_a);
  EXPECT_EQ(registry.create(), a);
  EXPECT_EQ(registry.find(a)->id, PanopticId{65535});
  EXPECT_EQ(registry.id_of(a), PanopticId{65535});
  EXPECT_EQ(registry.survivor(a), a);
  EXPECT_EQ(registry.survivor(PanopticId{kFirst}), PanopticId{kFirst + 1}) << "the id answers for ever";
  EXPECT_EQ(registry.create(), std::nullopt);
}

// A map that is made anew makes objects again under the ids that they had; what was merged into them still was.
TEST(ObjectRegistry, AnObjectThatIsMadeAgainKnowsWhatWasMergedIntoIt) {
  ObjectRegistry registry(kFirst);
  const LabelSlot a = *registry.create();
  const LabelSlot b = *registry.create();
  const PanopticId whole = registry.find(b)->id;
  registry.merge(a, b, 7);
  registry.retire_unused(std::vector<bool>(65536, false));
  ASSERT_EQ(registry.find(whole), nullptr);
  const LabelSlot again = *registry.recreate(whole, 9);
  EXPECT_EQ(registry.find(again)->id, whole);
  EXPECT_EQ(registry.find(again)->parts.count(), 1U);
  EXPECT_EQ(registry.survivor(PanopticId{kFirst}), whole);

  registry.merge_absent(PanopticId{kFirst + 5}, again, 11);
  EXPECT_EQ(registry.survivor(PanopticId{kFirst + 5}), whole);
  EXPECT_EQ(registry.find(again)->parts.count(), 2U);
  EXPECT_NE(*registry.create(), again);
}

TEST(ObjectRegistry, AnObjectWithoutVoxelsIsForgottenButItsSlotWaitsForWhatNamesIt) {
  ObjectRegistry registry(kFirst);
  const LabelSlot a = *registry.create();
  give_all_slots(registry);
  std::vector<bool> all_but_a(65536, true);
  all_but_a[number(a)] = false;
  registry.retire_unused(all_but_a, std::vector<bool>(65536, true));
  EXPECT_EQ(registry.find(a), nullptr);
  EXPECT_EQ(registry.find(PanopticId{kFirst}), nullptr);
  EXPECT_EQ(registry.named_by(a), PanopticId{kFirst});
  EXPECT_EQ(registry.id_of(a), PanopticId::kUnknown);
  EXPECT_EQ(registry.create(), std::nullopt);
  registry.retire_unused(all_but_a);
  EXPECT_EQ(registry.named_by(a), PanopticId::kUnknown);
  EXPECT_EQ(registry.create(), a);
}

TEST(ObjectRegistry, WhatWasNotToldApartHasItsClassNumberAsIdAndStrangersHaveNone) {
  ObjectRegistry registry(kFirst);
  const LabelSlot slot = *registry.create();
  EXPECT_EQ(registry.id_of(LabelSlot::kUnknown), PanopticId::kUnknown);
  EXPECT_EQ(registry.id_of(LabelSlot{kFirst - 1}), PanopticId{kFirst - 1});
  EXPECT_EQ(registry.id_of(slot), PanopticId{kFirst});
  for (const LabelSlot stranger : {LabelSlot{kFirst + 1}, LabelSlot::kNoVote}) {
    EXPECT_EQ(registry.id_of(stranger), PanopticId::kUnknown);
    EXPECT_EQ(registry.named_by(stranger), PanopticId::kUnknown);
  }
}

TEST(ObjectRegistry, KeepsTheLatestPartsAndHowManyThereWere) {
  ObjectRegistry registry(kFirst);
  const LabelSlot whole = *registry.create();
  for (int i = 0; i < 1000; ++i) registry.merge(*registry.create(), whole, i);
  const PartHistory& parts = registry.find(whole)->parts;
  EXPECT_EQ(parts.count(), 1000U);
  ASSERT_EQ(parts.latest().size(), PartHistory::kMost);
  EXPECT_EQ(parts.latest().back(), (ObjectPart{PanopticId{kFirst + 1000}, 999}));
  EXPECT_EQ(parts.latest().front(), (ObjectPart{PanopticId{kFirst + 1000 - 63}, 999 - 63}));
  EXPECT_EQ(registry.survivor(PanopticId{kFirst + 1}), PanopticId{kFirst}) << "of the others it is still known";
}

TEST(ObjectRegistry, GoesOnFromItsState) {
  ObjectRegistry registry(kFirst);
  std::vector<LabelSlot> slots;
  for (int i = 0; i < 6; ++i) slots.push_back(*registry.create(i));
  registry.merge(slots[0], slots[1], 7);
  std::vector<bool> in_use(65536, true);
  in_use[number(slots[2])] = false;
  registry.retire_unused(in_use);
  ObjectRegistry again(kFirst, registry.state());
  EXPECT_EQ(again.state(), registry.state());
  EXPECT_EQ(again.count(), 4U);
  EXPECT_EQ(again.find(PanopticId{kFirst + 5})->slot, slots[5]);
  EXPECT_EQ(again.create(), registry.create());
  EXPECT_EQ(again.state(), registry.state());
}

// Makes and loses as many objects as 400,000 labelled frames do: a handful is there at a time. Every id is given once, and
// every one that was merged is known for ever, in 8 bytes.
TEST(ObjectRegistry, NeverRunsOutOfIdsInALongLife) {
  constexpr int kFrames = test::kSanitized ? 130'000 : 400'000;  // either is more than there are slots
  constexpr std::size_t kAlive = 40;
  std::mt19937 random(11);
  ObjectRegistry registry(kFirst);
  std::vector<LabelSlot> alive;                 // what voxels hold
  std::vector<std::uint32_t> whole_of{kFirst};  // a naive record, by id - kFirst: parent ids
  std::uint32_t highest = kFirst - 1;
  std::size_t merges = 0;
  for (int frame = 0; frame < kFrames; ++frame) {
    const std::optional<LabelSlot> slot = registry.create(frame);
    ASSERT_TRUE(slot) << "frame " << frame;
    ASSERT_TRUE(std::find(alive.begin(), alive.end(), *slot) == alive.end()) << "the slot of an object that is";
    const std::uint32_t id = number(registry.find(*slot)->id);
    ASSERT_EQ(id, highest + 1);
    highest = id;
    whole_of.resize(id - kFirst + 1, id);
    whole_of.back() = id;
    const auto fate = static_cast<std::uint32_t>(random() % 100);
    if (fate < 19 && !alive.empty()) {
      const LabelSlot into = alive[random() % alive.size()];
      whole_of[id - kFirst] = number(registry.find(into)->id);
      registry.merge(*slot, into, frame);
      ++merges;
    } else if (fate >= 99) {
      if (alive.size() < kAlive) {
        alive.push_back(*slot);
      } else {  // an old object becomes a part of the new one
        LabelSlot& old = alive[random() % alive.size()];
        whole_of[number(registry.find(old)->id) - kFirst] = id;
        registry.merge(old, *slot, frame);
        old = *slot;
        ++merges;
      }
    }
    if (!registry.wants_retirement()) continue;
    std::vector<bool> in_use(kLabelSlots, false);
    for (const LabelSlot held : alive) in_use[number(held)] = true;
    registry.retire_unused(in_use);
    ASSERT_EQ(registry.count(), alive.size());
  }
  EXPECT_EQ(registry.refused(), 0U);
  EXPECT_EQ(number(registry.next_id()), highest + 1);
  EXPECT_LE(registry.state().objects.size(), kLabelSlots);
  EXPECT_LE(registry.state().left.size(), 2048U);
  static_assert(sizeof(MergedObject) == 8);
  EXPECT_EQ(registry.merged().size(), merges);
  EXPECT_LE(registry.merged().capacity() * sizeof(MergedObject), 16 * merges);
  ASSERT_GT(merges, kFrames / 6U);
  for (const MergedObject& merged : registry.merged()) {
    std::uint32_t at = number(merged.id);
    while (whole_of[at - kFirst] != at) at = whole_of[at - kFirst];
    ASSERT_EQ(number(merged.into), at);
    ASSERT_NE(registry.find(merged.into), nullptr) << "its survivor lives";
    ASSERT_EQ(registry.find(merged.id), nullptr);
  }
}

}  // namespace
}  // namespace panoptic
