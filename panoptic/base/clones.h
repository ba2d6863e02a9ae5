// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// PANOPTIC_CLONES compiles a function for AVX2 and AVX-512 too and picks at run time. The results are the same bits, since the
// build forbids contraction. Off under sanitizers (the resolver runs before TSan is up) and on clang 14 (it lacks the
// attribute's x86-64 levels). The function needs external linkage.
#pragma once

#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(__SANITIZE_THREAD__) && \
    !defined(__SANITIZE_ADDRESS__)
#define PANOPTIC_CLONES [[gnu::target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")]]
#else
#define PANOPTIC_CLONES
#endif
