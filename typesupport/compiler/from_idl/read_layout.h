// Reads the layout rules of a struct, @sft_layout.
#pragma once

#include "model.h"
#include "reading.h"

/// Returns the @sft_layout of a node; null if it has none.
const idl_annotation_appl_t* sft_layout_of(const idl_node_t* node);

/// Sets the rules of the members of `result`, which was read from `node`. Refuses rules that do not suit the
/// struct.
void sft_read_layouts(struct sft_reading* reading, const idl_struct_t* node, struct sft_declaration* result);
