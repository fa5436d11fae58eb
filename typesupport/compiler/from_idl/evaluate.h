// Evaluates values of @default that idlc has replaced by zero. idlc does that if the member's type is a
// typedef or a sequence.
#pragma once

#include "model.h"
#include "reading.h"

/// Returns the text of an expression in the IDL file. Returns null if the expression is not at the place
/// that idlc reports. The caller frees the text.
char* sft_source_text(const struct sft_reading* reading, const void* expression);

/// Makes idlc evaluate a literal, or an expression of literals, as a constant of `kind`. If idlc cannot
/// evaluate it, idlc reports the reason at the place of `expression`, and the result is unset. The file of
/// `reading` owns the text of a string.
struct sft_value sft_evaluate(struct sft_reading* reading, enum sft_kind kind, const char* text,
                              const void* expression);
