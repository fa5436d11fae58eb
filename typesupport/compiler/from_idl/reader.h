// Fills the model of a file from the tree that idlc parsed.
#pragma once

#include <stdbool.h>

#include "idl/processor.h"
#include "model.h"

/// Reads the main file of `state` into `file`, which is zero before but for `copies`, and the caller's to
/// free after, whatever the result. False if the file has something that is not supported: each such thing
/// was reported on stderr, one per line, as `file:line: scoped::Struct.member: what is wrong: what to do`.
/// Ends the process when memory runs out.
bool sft_read_file(const idl_pstate_t* state, struct sft_file* file);
