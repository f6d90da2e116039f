// A chunk of pixels on its way through the photometric kernel; small enough to stay in the processor's first cache.
#pragma once

#include "numerics/normal.h"
#include "numerics/vector_clones.h"
#include "photometric/kernel/photometric_kernel.h"

namespace seater_perception {

constexpr int kChunk = 128;  // [pixels] all 48 arrays of a chunk are 25 kB

/// White of each pixel of the chunk and its derivatives: motion (6), PSF (0, 1 or 3).
struct Chunk {
  alignas(64) float white[kChunk];
  alignas(64) float by[9][kChunk];
  alignas(64) float outside[kChunk];  // share that is beyond the quiet zone
};

/// Pixels first .. first + n - 1 of the batch (n a multiple of PixelBatch::kLanes, at most kChunk).
void renderChunk(const PixelBatch& batch, int first, int n, const MarkerView& view, int psf, Chunk& chunk);

}  // namespace seater_perception
