// Values of @default.
#pragma once

#include "model.h"
#include "reading.h"

/// Sets what `member`, whose type is known, starts with, from the @default of `node`, which has one. Refuses
/// what does not fit the type.
void sft_read_default(struct sft_reading* reading, const idl_member_t* node, struct sft_member* member);
