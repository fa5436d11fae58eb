// Memory of the reader. The process ends if there is no memory, since a compiler cannot continue.
#pragma once

#include <stddef.h>

#include "model.h"

/// Resizes `memory`, which may be null, to `bytes`.
void* sft_resized(void* memory, size_t bytes);

/// Returns `items` with memory for one more item after the `count` present items. The new item is filled
/// with zeros.
void* sft_grown(void* items, size_t count, size_t item_bytes);

/// Copies the text. The copy lives as long as the file.
const char* sft_keep_text(struct sft_file* file, const char* text);
