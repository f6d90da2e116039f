#pragma once

/// Compiles a function once for processors with AVX2 and once for all others; the loader picks the right one.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define SEATER_VECTOR_CLONES __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define SEATER_VECTOR_CLONES
#endif
