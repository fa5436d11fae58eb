// Types and values of idlc's tree as those of the model.
#pragma once

#include "model.h"
#include "reading.h"

/// The type that `spec` with the dimensions of `declarator` (may be null) makes, typedefs seen through.
/// Refuses what has no counterpart in the model; the result is then not to be used.
struct sft_type sft_read_type(struct sft_reading* reading, const idl_type_spec_t* spec,
                              const idl_declarator_t* declarator);

/// The value of a constant expression (a literal or an enumerator) that idlc has converted to `type`.
struct sft_value sft_read_value(const struct sft_type* type, const void* expression);

/// Whether it is one of a bitmask, and carried by an unsigned integer therefore, or a collection of those.
bool sft_is_bitmask(const struct sft_type* type);

/// Of an integer, no matter whether signed.
uint64_t sft_greatest_value(enum sft_kind kind);

/// The integer that carries an enumeration, or a bitmask.
enum sft_kind sft_enumeration_kind(const idl_enum_t* enumeration);
enum sft_kind sft_bitmask_kind(const idl_bitmask_t* bitmask);
