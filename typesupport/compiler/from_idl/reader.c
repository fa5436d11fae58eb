#include "reader.h"

#include <string.h>

#include "memory.h"
#include "read_default.h"
#include "read_layout.h"
#include "read_type.h"
#include "reading.h"

static void enter(struct sft_reading* reading, const void* node) {
  reading->node = node;
  reading->owner = sft_scoped_name(node);
  reading->member = NULL;
}

static struct sft_declaration* add_declaration(struct sft_reading* reading, enum sft_declaration_kind kind,
                                               const void* node) {
  struct sft_file* file = reading->file;
  enter(reading, node);
  file->declarations = sft_grown(file->declarations, file->declaration_count, sizeof *file->declarations);
  struct sft_declaration* added = &file->declarations[file->declaration_count++];
  added->kind = kind;
  added->name = reading->owner;
  return added;
}

static void read_constant(struct sft_reading* reading, const idl_const_t* node) {
  struct sft_declaration* constant = add_declaration(reading, SFT_CONSTANT, node);
  constant->type = sft_read_type(reading, node->type_spec, NULL);
  constant->value = sft_read_value(&constant->type, node->const_expr);
  if (sft_is_bitmask(&constant->type) && constant->value.natural > sft_greatest_value(constant->type.kind))
    sft_refuse(reading, "the value has bits beyond @bit_bound: use less");
}

static void read_typedef(struct sft_reading* reading, const idl_typedef_t* node) {
  const idl_declarator_t* declarator;
  IDL_FOREACH(declarator, node->declarators) {
    struct sft_declaration* alias = add_declaration(reading, SFT_ALIAS, declarator);
    alias->type = sft_read_type(reading, node->type_spec, declarator);
  }
}

static struct sft_enumerator* add_enumerator(struct sft_declaration* owner) {
  owner->enumerators = sft_grown(owner->enumerators, owner->enumerator_count, sizeof *owner->enumerators);
  return &owner->enumerators[owner->enumerator_count++];
}

static void read_enumeration(struct sft_reading* reading, const idl_enum_t* node) {
  struct sft_declaration* enumeration = add_declaration(reading, SFT_ENUMERATION, node);
  enumeration->type.kind = sft_enumeration_kind(node);
  const idl_enumerator_t* from;
  IDL_FOREACH(from, node->enumerators) {
    struct sft_enumerator* to = add_enumerator(enumeration);
    to->name = idl_identifier(from);
    to->value = from->value.value;
    if (to->value > sft_greatest_value(enumeration->type.kind)) {
      reading->node = from;
      reading->member = to->name;
      sft_refuse(reading, "the value does not fit the enumeration's signed integer: use a smaller one");
    }
  }
}

static void read_bitmask(struct sft_reading* reading, const idl_bitmask_t* node) {
  struct sft_declaration* bitmask = add_declaration(reading, SFT_BITMASK, node);
  bitmask->type.kind = sft_bitmask_kind(node);
  const idl_bit_value_t* from;
  IDL_FOREACH(from, node->bit_values) {
    struct sft_enumerator* flag = add_enumerator(bitmask);
    flag->name = idl_identifier(from);
    flag->value = UINT64_C(1) << from->position.value;  // idlc has checked that it fits
  }
}

static void check_annotations(struct sft_reading* reading, const idl_member_t* node) {
  if (node->optional.value) {
    sft_refuse(reading, "optional members are not supported: use a sequence with bound 1");
  }
  if (node->external.value) {
    sft_refuse(reading,
               "external members are not supported: remove @external, or use a sequence with bound 1");
  }
}

// XTypes says that a member without @default starts with its enumeration's default literal. The value is
// unset if that literal is zero, as in any value-initialized member.
static struct sft_value enumeration_default(const idl_type_spec_t* spec) {
  const idl_enum_t* enumeration = idl_strip(spec, IDL_STRIP_ALIASES | IDL_STRIP_ALIASES_ARRAY);
  const idl_enumerator_t* first = enumeration->default_enumerator;
  return (struct sft_value){.is_set = first->value.value != 0, .text = idl_identifier(first)};
}

static void read_initial(struct sft_reading* reading, const idl_member_t* node, struct sft_member* member) {
  const bool is_single = !member->type.is_sequence && member->type.dimension_count == 0;
  if (node->value.annotation != NULL) {
    sft_read_default(reading, node, member);
  } else if (is_single && idl_type(idl_strip(node->type_spec, IDL_STRIP_ALIASES)) == IDL_ENUM) {
    member->initial = enumeration_default(node->type_spec);
  }
}

static void read_member(struct sft_reading* reading, struct sft_declaration* owner, const idl_member_t* node,
                        const idl_declarator_t* declarator) {
  owner->members = sft_grown(owner->members, owner->member_count, sizeof *owner->members);
  struct sft_member* member = &owner->members[owner->member_count++];
  member->name = idl_identifier(declarator);
  reading->node = declarator;
  reading->member = member->name;
  const bool was_refused = reading->is_refused;
  reading->is_refused = false;
  member->type = sft_read_type(reading, node->type_spec, declarator);
  check_annotations(reading, node);
  if (!reading->is_refused) read_initial(reading, node, member);
  reading->is_refused |= was_refused;
  member->is_key = node->key.value;
  member->unit = node->unit.value;
}

static void read_struct(struct sft_reading* reading, const idl_struct_t* node) {
  struct sft_declaration* result = add_declaration(reading, SFT_STRUCT, node);
  if (node->inherit_spec != NULL) {
    sft_refuse(reading, "inheritance is not supported: make the base type the first member");
  }
  if (node->extensibility.value == IDL_MUTABLE) {
    sft_refuse(reading, "mutable types are not supported: use @final, or @appendable");
  }
  if (node->members == NULL) {
    sft_refuse(reading, "structs without members are not supported: add one, as ROS does");
  }
  const idl_member_t* member;
  IDL_FOREACH(member, node->members) {
    const idl_declarator_t* declarator;
    IDL_FOREACH(declarator, member->declarators) read_member(reading, result, member, declarator);
  }
  sft_read_layouts(reading, node, result);
}

// Refuses an unsupported declaration even if no member uses it.
static void refuse_declaration(struct sft_reading* reading, const void* node) {
  enter(reading, node);
  sft_read_type(reading, node, NULL);
}

static void read_declaration(struct sft_reading* reading, const idl_node_t* node) {
  if (sft_layout_of(node) != NULL) {
    enter(reading, node);
    sft_refuse(reading, "@sft_layout belongs to a member that is a sequence of numbers");
  }
  switch (idl_mask(node) & (IDL_CONST | IDL_TYPEDEF | IDL_ENUM | IDL_STRUCT | IDL_UNION | IDL_BITMASK)) {
    case IDL_CONST:
      read_constant(reading, (const idl_const_t*)node);
      break;
    case IDL_TYPEDEF:
      read_typedef(reading, (const idl_typedef_t*)node);
      break;
    case IDL_ENUM:
      read_enumeration(reading, (const idl_enum_t*)node);
      break;
    case IDL_STRUCT:
      read_struct(reading, (const idl_struct_t*)node);
      break;
    case IDL_BITMASK:
      read_bitmask(reading, (const idl_bitmask_t*)node);
      break;
    case IDL_UNION:
      refuse_declaration(reading, node);
      break;
    default:
      break;  // annotations that the file declares have no C++
  }
}

static void read_declarations(struct sft_reading* reading, const idl_node_t* first) {
  for (const idl_node_t* node = first; node != NULL; node = idl_next(node)) {
    if (idl_is_module(node)) {
      read_declarations(reading, ((const idl_module_t*)node)->definitions);
    } else if (!idl_is_forward(node) && sft_is_of_main_file(reading->file, node)) {
      read_declaration(reading, node);
    }
  }
}

static const char* original_path(const struct sft_file* file, const idl_source_t* source) {
  return sft_original_path(file->copies, source->path->name);
}

static void add_unique(const char*** paths, size_t* count, const char* path) {
  for (size_t i = 0; i < *count; ++i) {
    if (strcmp((*paths)[i], path) == 0) return;
  }
  *paths = sft_grown(*paths, *count, sizeof **paths);
  (*paths)[(*count)++] = path;
}

static void read_sources(struct sft_file* file, const idl_source_t* source) {
  add_unique(&file->sources, &file->source_count, original_path(file, source));
  for (const idl_source_t* included = source->includes; included != NULL; included = included->next) {
    read_sources(file, included);
  }
}

bool sft_read_file(const idl_pstate_t* state, struct sft_file* file) {
  const idl_source_t* main_source = state->sources;
  file->path = original_path(file, main_source);
  read_sources(file, main_source);
  for (const idl_source_t* included = main_source->includes; included != NULL; included = included->next) {
    add_unique(&file->includes, &file->include_count, original_path(file, included));
  }
  struct sft_reading reading = {.file = file};
  read_declarations(&reading, state->root);
  return !reading.is_refused;
}
