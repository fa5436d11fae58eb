// Fills the model of a file from the tree that idlc parsed.
#pragma once

#include <stdbool.h>

#include "idl/processor.h"
#include "model.h"

/// Reads the main file of `state` into `file`. Returns false if the file contains anything unsupported.
/// Each unsupported construct is reported on stderr, in a line `file:line: scoped::Struct.member: what is
/// wrong: what to do`. The caller frees `file` in both cases. Ends the process if memory runs out.
/// REQUIRES: `file` is zero except for `copies`.
bool sft_read_file(const idl_pstate_t* state, struct sft_file* file);
