// SPDX-License-Identifier: Apache-2.0
#pragma once

#if defined(__has_feature)  // clang says by this what GCC says by __SANITIZE_ADDRESS__
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define PLUMBLINE_SANITIZED
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define PLUMBLINE_SANITIZED
#endif

/// Compiles a function three times, also for processors that take eight floats at once (AVX2) and
/// sixteen (AVX-512). All give the same bits: operations are never fused (-ffp-contract=off). Only
/// for functions of one source file: clang 14 compiles what a header declares without this once,
/// and says nothing. Not with sanitizers, which are not up yet when the loader chooses.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(PLUMBLINE_SANITIZED)
#define PLUMBLINE_VECTORISED __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define PLUMBLINE_VECTORISED
#endif
