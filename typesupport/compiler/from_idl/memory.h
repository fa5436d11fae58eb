// Memory of the reader. A compiler without any has nothing better to do than end: so does this.
#pragma once

#include <stddef.h>

#include "model.h"

/// `memory`, which may be null, with a size of `bytes`.
void* sft_resized(void* memory, size_t bytes);

/// Room for one more item, zero, behind `count` of them.
void* sft_grown(void* items, size_t count, size_t item_bytes);

/// A copy that lives as long as the file.
const char* sft_keep_text(struct sft_file* file, const char* text);
