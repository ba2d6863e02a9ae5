// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/batch/batch_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/files.h"
#include "panoptic/batch/batch_report.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::fresh_folder;
using testing::HasSubstr;
namespace fs = std::filesystem;

SceneTask task_of(const std::string& name, const std::string& script) {
  SceneTask task;
  task.record.scene = {name, "sim:1"};
  task.record.fingerprint = "f";
  task.folder = fresh_folder(name);
  task.steps = {{{"sh", "-c", script}, {}, {}, {}}};
  return task;
}

std::vector<SceneRecord> run_all(const std::vector<SceneTask>& tasks, int jobs) {
  std::vector<SceneRecord> ended;
  EXPECT_TRUE(run_scenes(tasks, jobs, {[&](const SceneRecord& r) { ended.push_back(r); }, [] { return true; }}));
  return ended;
}

TEST(RunScenes, TriesWhatFailedOnceMoreAndSaysWhy) {
  const std::vector<SceneRecord> ended = run_all({task_of("scene", "echo 'panoptic: no depth' >&2; echo bye; exit 1")}, 1);
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_EQ(ended[0].state, SceneState::kFailed);
  EXPECT_EQ(ended[0].attempts, 2);
  EXPECT_EQ(ended[0].reason, "no depth");
}

TEST(RunScenes, TellsOfASignalAndOfRunsThatLeftNothing) {
  const std::vector<SceneRecord> ended = run_all({task_of("a", "echo 'half way'; kill -9 $$"), task_of("b", "exit 0")}, 2);
  ASSERT_EQ(ended.size(), 2U);
  for (const SceneRecord& record : ended) {
    EXPECT_THAT(record.reason, HasSubstr(record.scene.name == "a" ? "killed (by the system" : "report.json"));
    EXPECT_EQ(record.state, SceneState::kFailed);
  }
}

TEST(RunScenes, HasSoManyAtATimeAsItIsTold) {
  const fs::path meeting = fresh_folder("meeting");
  // Each waits until it has seen another one.
  const std::string script = "touch $0; while [ $(ls | wc -l) -lt 2 ]; do sleep 0.01; done; exit 3";
  std::vector<SceneTask> tasks;
  for (const std::string name : {"a", "b"}) {
    tasks.push_back(task_of(name, ""));
    tasks.back().steps = {{{"sh", "-c", "cd " + meeting.string() + "; " + script, name}, {}, {}, {}}};
  }
  EXPECT_EQ(run_all(tasks, 2).size(), 2U);
}

TEST(RunScenes, MakesWhatOthersUseOnceAndAtOnce) {
  const fs::path folder = fresh_folder("shared");
  write_file(fs::path(fresh_folder("shared/.partial")) / "left", "by a batch that was killed");
  SceneTask task = task_of("scene", "exit 1");
  const BatchStep step{{"sh", "-c", "mkdir $0 && echo x >> $0/made", (folder / ".partial").string()},
                       folder / "scene",
                       folder / ".partial",
                       "by us\n"};
  task.steps.insert(task.steps.begin(), step);
  run_all({task}, 1);
  run_all({task}, 1);
  EXPECT_EQ(read_file(folder / "scene" / "made"), "x\n") << "once, although the step after it failed four times";
  EXPECT_EQ(read_file(folder / "scene" / "made_by.txt"), "by us\n");
  EXPECT_FALSE(fs::exists(folder / "scene" / "left"));
  EXPECT_FALSE(fs::exists(folder / ".partial"));
}

TEST(RunScenes, DoesNotUseWhatWasMadeOfOtherThings) {
  const fs::path folder = fresh_folder("shared");
  SceneTask task = task_of("scene", "touch used");
  const BatchStep step{{"mkdir", (folder / ".partial").string()}, folder / "scene", folder / ".partial", "by us\n"};
  task.steps.insert(task.steps.begin(), step);
  fs::create_directories(folder / "scene");
  write_file(folder / "scene" / "made_by.txt", "by others\n");
  const std::vector<SceneRecord> ended = run_all({task}, 1);
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_EQ(ended[0].state, SceneState::kFailed);
  EXPECT_THAT(ended[0].reason, HasSubstr("was made by another program"));
}

TEST(RunScenes, EndsItsProgramsWhenToldToStopAndRecordsNothing) {
  const std::vector<SceneTask> tasks{task_of("a", "exec sleep 1000"), task_of("b", "exec sleep 1000")};
  int asked = 0;
  const BatchWatch watch{[](const SceneRecord&) { FAIL(); }, [&] { return ++asked < 20; }};
  EXPECT_FALSE(run_scenes(tasks, 2, watch));
  EXPECT_FALSE(read_record(tasks[0].folder));
}

TEST(SceneRecord, IsReadAsItWasWritten) {
  const fs::path folder = fresh_folder();
  const SceneRecord record{{"a", "sim:1"}, "f", SceneState::kFinished, true, 2, 1.5, 100, 7, 3, "hash", "why|"};
  write_record(folder, record);
  const auto again = read_record(folder);
  ASSERT_TRUE(again);
  EXPECT_EQ(to_json(*again), to_json(record));
  EXPECT_TRUE(is_finished(again, "f"));
  EXPECT_FALSE(is_finished(again, "g"));
  write_file(folder / "scene.json", "{\"name\": ");
  EXPECT_FALSE(read_record(folder));
  Json other = to_json(record);
  other["state"] = "paused";
  write_json_file(folder / "scene.json", other);
  EXPECT_FALSE(read_record(folder)) << "a state of another version";
  write_file(folder / "scene.json", "{}");
  EXPECT_FALSE(read_record(folder));
}

TEST(BatchReport, HasALineForEachScene) {
  const fs::path folder = fresh_folder();
  BatchReport report{"list.txt", {"--no-pictures"}, 2, 3, 1, {}, ""};
  report.scenes = {{{"a", "sim:1"}, "f", SceneState::kFinished, false, 1, 1.5, 100, 7, 3, "hash", ""},
                   {{"b", "sim:2"}, "f", SceneState::kFailed, false, 2, 2.5, 50, 0, 0, "", "a|b"},
                   {{"c", "sim:3"}, "f"}};
  write_batch_report(folder, report);
  const std::string text = read_file(folder / "batch.md");
  EXPECT_THAT(text, HasSubstr("1 done, 1 failed, 1 waiting; 4 s for all scenes together, at most 100 MB"));
  EXPECT_THAT(text, HasSubstr("| a | done | 1.5 | 100 | 7 | 3 | |\n| b | FAILED | 2.5 | 50 | | | a\\|b |\n| c | waiting |"));
  const Json json = read_json_file(folder / "batch.json");
  EXPECT_EQ(json.at("complete"), false);
  EXPECT_EQ(json.at("scenes").at(1).at("reason"), "a|b");
}

}  // namespace
}  // namespace panoptic
