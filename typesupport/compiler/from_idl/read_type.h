// Translates types and values of idlc's tree to those of the model.
#pragma once

#include "model.h"
#include "reading.h"

/// Returns the type of `spec` with the dimensions of `declarator`, which may be null, and with typedefs
/// resolved. Refuses types that the model lacks. The caller must not use the result for a refused type.
struct sft_type sft_read_type(struct sft_reading* reading, const idl_type_spec_t* spec,
                              const idl_declarator_t* declarator);

/// Returns the value of a constant expression, a literal or an enumerator, which idlc has converted to
/// `type`.
struct sft_value sft_read_value(const struct sft_type* type, const void* expression);

/// Sets the kind of a primitive type. Returns false for any other type, and for a primitive that the model
/// lacks.
bool sft_primitive_kind(idl_type_t type, enum sft_kind* kind);

/// Returns true for a bitmask, whose values are unsigned integers, and for a collection of bitmasks.
bool sft_is_bitmask(const struct sft_type* type);

/// Returns the greatest value of a signed or unsigned integer kind.
uint64_t sft_greatest_value(enum sft_kind kind);

/// Returns the integer kind that holds the values of an enumeration, or of a bitmask.
enum sft_kind sft_enumeration_kind(const idl_enum_t* enumeration);
enum sft_kind sft_bitmask_kind(const idl_bitmask_t* bitmask);
