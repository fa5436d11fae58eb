// Memory of the reader. The process ends if there is none, since a compiler can do nothing better.
#pragma once

#include <stddef.h>

#include "model.h"

/// Resizes `memory`, which may be null, to `bytes`.
void* sft_resized(void* memory, size_t bytes);

/// Returns `items` with room for one more item, filled with zeros, behind `count` items.
void* sft_grown(void* items, size_t count, size_t item_bytes);

/// Copies the text. The copy exists as long as the file.
const char* sft_keep_text(struct sft_file* file, const char* text);
