#include "read_type.h"

#include <string.h>

static const struct {
  idl_type_t type;
  enum sft_kind kind;
} primitives[] = {
    {IDL_BOOL, SFT_BOOLEAN},  {IDL_OCTET, SFT_OCTET},   {IDL_CHAR, SFT_CHARACTER}, {IDL_INT8, SFT_INT8},
    {IDL_UINT8, SFT_UINT8},   {IDL_SHORT, SFT_INT16},   {IDL_INT16, SFT_INT16},    {IDL_USHORT, SFT_UINT16},
    {IDL_UINT16, SFT_UINT16}, {IDL_LONG, SFT_INT32},    {IDL_INT32, SFT_INT32},    {IDL_ULONG, SFT_UINT32},
    {IDL_UINT32, SFT_UINT32}, {IDL_LLONG, SFT_INT64},   {IDL_INT64, SFT_INT64},    {IDL_ULLONG, SFT_UINT64},
    {IDL_UINT64, SFT_UINT64}, {IDL_FLOAT, SFT_FLOAT32}, {IDL_DOUBLE, SFT_FLOAT64},
};

bool sft_primitive_kind(idl_type_t type, enum sft_kind* kind) {
  for (size_t i = 0; i < sizeof primitives / sizeof primitives[0]; ++i) {
    if (primitives[i].type == type) {
      *kind = primitives[i].kind;
      return true;
    }
  }
  return false;
}

static void read_primitive(struct sft_reading* reading, idl_type_t type, struct sft_type* result) {
  if (sft_primitive_kind(type, &result->kind)) return;
  switch (type) {
    case IDL_WCHAR:
      sft_refuse(reading, "wide characters are not supported: use string, which holds UTF-8");
      break;
    case IDL_LDOUBLE:
      sft_refuse(reading, "long double is not supported: use double");
      break;
    default:
      sft_refuse(reading, "this type is not supported: use a struct, an enum, a string or a primitive");
  }
}

// Only the declarations before the last one are complete, because the last one is still being read.
static bool is_complete(const struct sft_file* file, const void* definition, const char* name) {
  if (!sft_is_of_main_file(file, definition)) return true;
  for (size_t i = 0; i + 1 < file->declaration_count; ++i) {
    if (file->declarations[i].kind == SFT_STRUCT && strcmp(file->declarations[i].name, name) == 0)
      return true;
  }
  return false;
}

static void read_struct_use(struct sft_reading* reading, const void* definition, struct sft_type* result) {
  result->kind = SFT_STRUCTURE;
  result->name = sft_scoped_name(definition);
  if (is_complete(reading->file, definition, result->name)) return;
  if (strcmp(result->name, reading->owner) == 0) {
    sft_refuse(
        reading,
        "recursive types are not supported: hold all nodes in one sequence and refer to them by index");
  } else {
    sft_refuse(reading, "%s is not complete here and recursive types are not supported: define it further up",
               result->name + strlen("::"));
  }
}

static void read_element(struct sft_reading* reading, const idl_type_spec_t* spec, struct sft_type* result) {
  switch (idl_type(spec)) {
    case IDL_STRUCT:
      read_struct_use(reading, spec, result);
      break;
    case IDL_ENUM:
      result->kind = sft_enumeration_kind(spec);
      result->name = sft_scoped_name(spec);
      break;
    case IDL_BITMASK:
      result->kind = sft_bitmask_kind(spec);
      result->name = sft_scoped_name(spec);
      break;
    case IDL_STRING:
      result->kind = SFT_STRING;
      result->string_bound = ((const idl_string_t*)spec)->maximum;
      break;
    case IDL_UNION:
      sft_refuse(reading,
                 "unions are not supported: use a struct with a member that says which of the others counts");
      break;
    default:
      read_primitive(reading, idl_type(spec), result);
  }
}

static bool read_dimensions(struct sft_reading* reading, const idl_declarator_t* declarator,
                            struct sft_type* result) {
  const idl_literal_t* dimension;
  IDL_FOREACH(dimension, declarator->const_expr) {
    if (result->is_sequence) {
      sft_refuse(reading, "sequences of arrays are not supported: put the array into a struct");
      return false;
    }
    if (result->dimension_count == SFT_DIMENSIONS_MAX) {
      sft_refuse(reading, "more than %d dimensions are not supported: put inner ones into a struct",
                 SFT_DIMENSIONS_MAX);
      return false;
    }
    result->dimensions[result->dimension_count++] = dimension->value.uint32;
  }
  return true;
}

static bool read_sequence(struct sft_reading* reading, const idl_sequence_t* sequence,
                          struct sft_type* result) {
  if (result->dimension_count > 0) {
    sft_refuse(reading, "arrays of sequences are not supported: put the sequence into a struct");
    return false;
  }
  if (result->is_sequence) {
    sft_refuse(reading, "sequences of sequences are not supported: put the inner one into a struct");
    return false;
  }
  result->is_sequence = true;
  result->bound = sequence->maximum;
  return true;
}

static void check_element_count(struct sft_reading* reading, const struct sft_type* type) {
  uint64_t count = 1;
  for (size_t i = 0; i < type->dimension_count; ++i) {
    count *= type->dimensions[i];
    if (count == 0 || count > INT32_MAX) {
      sft_refuse(reading,
                 "arrays of no or of more than 2147483647 elements are not supported: use a sequence");
      return;
    }
  }
}

struct sft_type sft_read_type(struct sft_reading* reading, const idl_type_spec_t* spec,
                              const idl_declarator_t* declarator) {
  struct sft_type result = {0};
  bool is_good = declarator == NULL || read_dimensions(reading, declarator, &result);
  while (is_good) {
    if (idl_is_forward(spec)) {
      spec = idl_type_spec(spec);
    } else if (idl_is_alias(spec)) {
      is_good = read_dimensions(reading, spec, &result);
      spec = idl_type_spec(spec);
    } else if (idl_is_sequence(spec)) {
      is_good = read_sequence(reading, spec, &result);
      spec = idl_type_spec(spec);
    } else {
      read_element(reading, spec, &result);
      check_element_count(reading, &result);
      return result;
    }
  }
  return result;
}

static struct sft_value read_literal(enum sft_kind kind, const idl_literal_t* literal) {
  struct sft_value result = {.is_set = true};
  if (idl_type(literal) == IDL_BITMASK) {  // idlc leaves it as wide as it has calculated
    result.natural = literal->value.uint64;
    return result;
  }
  switch (kind) {
    case SFT_BOOLEAN:
      result.boolean = literal->value.bln;
      break;
    case SFT_CHARACTER:
      result.character = literal->value.chr;
      break;
    case SFT_OCTET:
    case SFT_UINT8:
      result.natural = literal->value.uint8;
      break;
    case SFT_UINT16:
      result.natural = literal->value.uint16;
      break;
    case SFT_UINT32:
      result.natural = literal->value.uint32;
      break;
    case SFT_UINT64:
      result.natural = literal->value.uint64;
      break;
    case SFT_INT8:
      result.integer = literal->value.int8;
      break;
    case SFT_INT16:
      result.integer = literal->value.int16;
      break;
    case SFT_INT32:
      result.integer = literal->value.int32;
      break;
    case SFT_INT64:
      result.integer = literal->value.int64;
      break;
    case SFT_FLOAT32:
      result.real = literal->value.flt;
      break;
    case SFT_FLOAT64:
      result.real = literal->value.dbl;
      break;
    case SFT_STRING:
      result.text = literal->value.str;
      break;
    case SFT_STRUCTURE:
      break;
  }
  return result;
}

struct sft_value sft_read_value(const struct sft_type* type, const void* expression) {
  if (idl_is_enumerator(expression))
    return (struct sft_value){.is_set = true, .text = idl_identifier(expression)};
  return read_literal(type->kind, expression);
}

enum sft_kind sft_enumeration_kind(const idl_enum_t* enumeration) {
  if (enumeration->bit_bound.value <= 8) return SFT_INT8;
  return enumeration->bit_bound.value <= 16 ? SFT_INT16 : SFT_INT32;
}

enum sft_kind sft_bitmask_kind(const idl_bitmask_t* bitmask) {
  if (bitmask->bit_bound.value <= 8) return SFT_UINT8;
  if (bitmask->bit_bound.value <= 16) return SFT_UINT16;
  return bitmask->bit_bound.value <= 32 ? SFT_UINT32 : SFT_UINT64;
}

bool sft_is_bitmask(const struct sft_type* type) {
  if (type->name == NULL) return false;
  return type->kind == SFT_UINT8 || type->kind == SFT_UINT16 || type->kind == SFT_UINT32 ||
         type->kind == SFT_UINT64;
}

uint64_t sft_greatest_value(enum sft_kind kind) {
  switch (kind) {
    case SFT_INT8:
      return INT8_MAX;
    case SFT_UINT8:
      return UINT8_MAX;
    case SFT_INT16:
      return INT16_MAX;
    case SFT_UINT16:
      return UINT16_MAX;
    case SFT_INT32:
      return INT32_MAX;
    case SFT_UINT32:
      return UINT32_MAX;
    case SFT_INT64:
      return INT64_MAX;
    default:
      return UINT64_MAX;
  }
}
