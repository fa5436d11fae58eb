// Evaluates values of @default that idlc has not kept. idlc replaces them by zero if the member's type is a
// typedef or a sequence.
#pragma once

#include "model.h"
#include "reading.h"

/// The text of an expression in the IDL file; null if the file does not have it where idlc says. The caller
/// frees it.
char* sft_source_text(const struct sft_reading* reading, const void* expression);

/// Lets idlc evaluate a literal, or an expression of literals, as a constant of `kind`. If idlc cannot, it
/// reports the reason for the place of `expression`, and the result is unset. The file of `reading` owns the
/// text of a string.
struct sft_value sft_evaluate(struct sft_reading* reading, enum sft_kind kind, const char* text,
                              const void* expression);
