// Expressions that idlc has not kept: it replaces the values of @default by zero unless the member's type is
// named without a typedef, and has no sequence.
#pragma once

#include "model.h"
#include "reading.h"

/// The text of an expression as the IDL file has it, to be freed; null if it is not found where idlc says
/// that it is.
char* sft_source_text(const struct sft_reading* reading, const void* expression);

/// Lets idlc evaluate the text of a literal, or of an expression of literals, as a constant of `kind`. Unset
/// if it cannot: it then says why, as of the place of `expression`. Text is kept by the file.
struct sft_value sft_evaluate(struct sft_reading* reading, enum sft_kind kind, const char* text,
                              const void* expression);
