// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The one seam to threads for data-parallel loops: oneTBB, or plain std::thread in the tsan preset.
#pragma once

#include <cstddef>
#include <functional>

namespace panoptic {

// Threads that parallel_for may use; 0 = one per core. Call it before work starts, not during. In a child of fork whose parent
// had set it or worked by then there is one, for good (with oneTBB).
void set_thread_count(int threads);
int thread_count();

// Calls body(i) once for every i in [0, count), in any order, on any thread, and returns when all are done.
// The first exception that a body throws is thrown again here. For results that do not depend on the thread count,
// let body(i) write only what belongs to i.
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body);

}  // namespace panoptic
