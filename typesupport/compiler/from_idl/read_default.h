// Reads the values of @default annotations.
#pragma once

#include "model.h"
#include "reading.h"

/// Sets the initial value of `member` from the @default of `node`. Refuses a value that does not fit the
/// type. REQUIRES: `node` has a @default, and the type of `member` is set.
void sft_read_default(struct sft_reading* reading, const idl_member_t* node, struct sft_member* member);
