// SPDX-License-Identifier: Apache-2.0
#include <oneapi/tbb/global_control.h>

/// Linked into the thread sanitizer's programs only. TBB hands work to its threads by means that
/// the sanitizer does not see, so that every parallel loop would look like a race; with one thread
/// there is none to see, and threads of our own are checked. Tests of the release build ask
/// parallel loops for the same result from any number of threads.
const oneapi::tbb::global_control one_tbb_thread(
    oneapi::tbb::global_control::max_allowed_parallelism, 1);
