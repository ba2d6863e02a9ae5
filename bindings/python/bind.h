// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The Python module in parts, and what keeps it sound: whatever Python hands over, the answer is a result or an exception.
//
// Everything here is called with Python's lock (the GIL) held, but for the work that `released` is given. Objects that the
// library wants used by one thread at a time have an Exclusive, which work takes before it gives the lock away. Objects with
// threads of their own are in a WithThreads, because a child of fork gets the objects and none of the threads.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "panoptic/error.h"

namespace panoptic::python {

namespace py = pybind11;

void bind_labels(py::module_& m);
void bind_options(py::module_& m);
void bind_frames(py::module_& m);
void bind_segments(py::module_& m);
void bind_sources(py::module_& m);
void bind_predictors(py::module_& m);
void bind_mesh(py::module_& m);
void bind_map(py::module_& m);
void bind_mapper(py::module_& m);
void bind_online(py::module_& m);
void bind_scores(py::module_& m);
void bind_tools(py::module_& m);
void bind_poses(py::module_& m);
void bind_free_space(py::module_& m);
void bind_planning(py::module_& m);
void bind_distances(py::module_& m);
void bind_navigation(py::module_& m);
void bind_home_plan(py::module_& m);
void bind_tracking(py::module_& m);

// Lines that a person should read, as warnings of Python.
inline void warn(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) py::module_::import("warnings").attr("warn")(line, py::arg("stacklevel") = 2);
}

// How many forks lie between the first process and this one.
inline int generation = 0;

// Whether this process, or one that it was forked from, made networks.
inline bool made_networks = false;

// How much work runs without Python's lock, online pipelines included.
inline std::atomic<int> work_in_progress = 0;

// Says for how long it lives that work is in progress.
class WorkInProgress {
 public:
  WorkInProgress() { ++work_in_progress; }
  ~WorkInProgress() {
    if (begun_in_ == generation) --work_in_progress;
  }
  WorkInProgress(const WorkInProgress&) = delete;
  WorkInProgress& operator=(const WorkInProgress&) = delete;

 private:
  int begun_in_ = generation;
};

// The thread in which the program ends, once it does: the others begin no more work. A thread that wanted Python's lock back from
// a Python that is gone would take the program down.
inline std::optional<std::thread::id> ending_in = {};
inline bool is_ending() { return ending_in && *ending_in != std::this_thread::get_id(); }

// Does work that touches nothing of Python, without its lock.
template <typename Work>
auto released(const Work& work) {
  if (is_ending()) throw Error("the program is ending: no more work is begun");
  const WorkInProgress in_progress;
  const py::gil_scoped_release release;
  return work();
}

// An object with threads of its own. In a child of fork it can neither work nor end, so it is refused there, and left as it is.
template <typename T>
class WithThreads {
 public:
  WithThreads() = default;
  explicit WithThreads(std::unique_ptr<T> object, bool has_threads = true)
      : object_(std::move(object)), has_threads_(has_threads) {}
  ~WithThreads() {
    if (is_lost()) static_cast<void>(object_.release());
  }
  WithThreads(const WithThreads&) = delete;
  WithThreads& operator=(const WithThreads&) = delete;
  WithThreads(WithThreads&&) = default;
  WithThreads& operator=(WithThreads&&) = default;

  bool is_lost() const { return has_threads_ && made_in_ != generation; }
  // Throws Error in a child.
  T& operator*() const {
    if (is_lost()) throw Error("it was made in the parent of this process, where its threads are: make a new one here");
    return *object_;
  }
  T* operator->() const { return &**this; }

 private:
  std::unique_ptr<T> object_;
  bool has_threads_ = true;
  int made_in_ = generation;
};

// An object that one thread at a time may use. Guarded by Python's lock.
class Exclusive {
 public:
  explicit Exclusive(std::string what) : what_(std::move(what)) {}

  // Throws Error if somebody has it.
  void take(const char* user) {
    if (user_ != nullptr) {
      throw Error("the " + what_ + " is in use by " + user_ + ": one thread at a time, so wait for it or use a lock");
    }
    user_ = user;
  }
  void give_back() { user_ = nullptr; }

 private:
  std::string what_;
  const char* user_ = nullptr;
};

// Has an object for as long as it lives. Declare it before the lock is given away.
class Use {
 public:
  explicit Use(Exclusive& object, const char* user = "another call") : object_(object) { object_.take(user); }
  ~Use() { object_.give_back(); }
  Use(const Use&) = delete;
  Use& operator=(const Use&) = delete;

 private:
  Exclusive& object_;
};

}  // namespace panoptic::python
