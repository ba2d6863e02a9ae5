// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/limits/allocation_meter.h"

#include <algorithm>
#include <atomic>
#include <cstdint>

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/allocator_interface.h>
#else
#include <malloc.h>
#endif

namespace {

std::atomic<std::size_t> largest{0};
std::atomic<std::size_t> peak{0};
std::atomic<std::int64_t> held{0};
std::atomic<bool> is_counting{false};

void raise_to(std::atomic<std::size_t>& value, std::size_t to) {
  std::size_t seen = value;
  while (seen < to && !value.compare_exchange_weak(seen, to)) continue;
}

void took(std::size_t asked) {
  if (!is_counting) return;
  raise_to(largest, asked);
  const std::int64_t now = held += static_cast<std::int64_t>(asked);
  raise_to(peak, static_cast<std::size_t>(std::max<std::int64_t>(now, 0)));
}

void gave(std::size_t bytes) {
  if (is_counting) held -= static_cast<std::int64_t>(bytes);
}

}  // namespace

#if defined(__SANITIZE_ADDRESS__)

namespace {

void on_malloc(const volatile void*, std::size_t size) { took(size); }
void on_free(const volatile void* at) {
  if (at != nullptr && is_counting) gave(__sanitizer_get_allocated_size(const_cast<const void*>(at)));
}
const int installed = __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free);

}  // namespace

#else

// The C library's own, under the names that it keeps for those who replace them.
// NOLINTBEGIN(readability-inconsistent-declaration-parameter-name)
extern "C" {
void* __libc_malloc(std::size_t size);                           // NOLINT
void* __libc_calloc(std::size_t count, std::size_t size);        // NOLINT
void* __libc_realloc(void* at, std::size_t size);                // NOLINT
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT
void __libc_free(void* at);                                      // NOLINT

void* malloc(std::size_t size) {
  void* at = __libc_malloc(size);
  if (at != nullptr) took(std::max(size, malloc_usable_size(at)));
  return at;
}
void* calloc(std::size_t count, std::size_t size) {
  void* at = __libc_calloc(count, size);
  if (at != nullptr) took(malloc_usable_size(at));
  return at;
}
void* realloc(void* before, std::size_t size) {
  const std::size_t bytes_before = before == nullptr ? 0 : malloc_usable_size(before);
  void* at = __libc_realloc(before, size);
  if (at != nullptr) gave(bytes_before);
  if (at != nullptr) took(malloc_usable_size(at));
  return at;
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  void* at = __libc_memalign(alignment, size);
  if (at != nullptr) took(malloc_usable_size(at));
  return at;
}
void* memalign(std::size_t alignment, std::size_t size) { return aligned_alloc(alignment, size); }
int posix_memalign(void** at, std::size_t alignment, std::size_t size) {
  constexpr int kNoMemory = 12;
  *at = aligned_alloc(alignment, size);
  return *at == nullptr ? kNoMemory : 0;
}
void free(void* at) {
  if (at != nullptr) gave(malloc_usable_size(at));
  __libc_free(at);
}
}
// NOLINTEND(readability-inconsistent-declaration-parameter-name)

#endif

namespace panoptic::test {

Allocations allocations_of(const std::function<void()>& action) {
  largest = peak = 0;
  held = 0;
  is_counting = true;
  action();
  is_counting = false;
  return {largest, peak};
}

}  // namespace panoptic::test
