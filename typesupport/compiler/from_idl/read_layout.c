#include "read_layout.h"

#include <stdlib.h>
#include <string.h>

#include "layout/check.h"
#include "memory.h"
#include "read_type.h"

// The rules of a struct as they are written in the file.
struct rules {
  struct sft_rule* list;
  const idl_annotation_appl_t** places;
  size_t count;
};

// Returns the layout annotation of a node. There is at most one: idlc refuses a second one that differs, and
// drops one that is equal.
const idl_annotation_appl_t* sft_layout_of(const idl_node_t* node) {
  const idl_annotation_appl_t* annotation;
  IDL_FOREACH(annotation, node->annotations) {
    if (strcmp(annotation->annotation->name->identifier, "sft_layout") == 0) return annotation;
  }
  return NULL;
}

static struct sft_seen seen_of(const idl_member_t* member, const idl_declarator_t* declarator) {
  struct sft_seen seen = {.name = idl_identifier(declarator), .kind = SFT_STRING};
  const idl_type_spec_t* spec = member->type_spec;
  if (declarator->const_expr != NULL) seen.shape = SFT_ARRAY;
  while (idl_is_forward(spec) || idl_is_alias(spec) || idl_is_sequence(spec)) {
    if (idl_is_alias(spec) && ((const idl_declarator_t*)spec)->const_expr != NULL) seen.shape = SFT_ARRAY;
    if (idl_is_sequence(spec)) seen.shape = SFT_SEQUENCE;
    spec = idl_type_spec(spec);
  }
  if (idl_is_struct(spec)) {
    seen.kind = SFT_STRUCTURE;
    seen.type = spec;
  } else if (idl_is_enum(spec)) {
    seen.kind = sft_enumeration_kind(spec);
  } else if (idl_is_bitmask(spec)) {
    seen.kind = sft_bitmask_kind(spec);
  } else {
    sft_primitive_kind(idl_type(spec), &seen.kind);
  }
  return seen;
}

static struct sft_seen see(const void* type, size_t i) {
  const idl_member_t* member;
  IDL_FOREACH(member, ((const idl_struct_t*)type)->members) {
    const idl_declarator_t* declarator;
    IDL_FOREACH(declarator, member->declarators) {
      if (i-- == 0) return seen_of(member, declarator);
    }
  }
  return (struct sft_seen){.name = NULL};
}

static const char* text_of(const idl_annotation_appl_t* annotation) {
  const idl_annotation_appl_param_t* parameter = annotation->parameters;
  const bool is_text = parameter != NULL && idl_type(parameter->const_expr) == IDL_STRING;
  return is_text ? ((const idl_literal_t*)parameter->const_expr)->value.str : "";
}

// The column is right if the text is a single literal without escapes, which is the usual form.
static void refuse(struct sft_reading* reading, const idl_annotation_appl_t* annotation,
                   const struct sft_rule_fault* fault) {
  const idl_annotation_appl_param_t* parameter = annotation->parameters;
  reading->node = parameter == NULL ? (const void*)annotation : parameter->const_expr;
  const uint32_t behind_quote = parameter == NULL ? 0 : 1;
  reading->column = idl_location(reading->node)->first.column + behind_quote + (uint32_t)fault->at;
  sft_refuse(reading, "%s", fault->text);
  reading->column = 0;
}

static void read_layout(struct sft_reading* reading, const idl_annotation_appl_t* annotation,
                        struct sft_member* member, size_t index, struct rules* rules) {
  struct sft_rule_fault fault;
  char* text = sft_layout_text(text_of(annotation), &fault);
  if (text == NULL) {
    refuse(reading, annotation, &fault);
    return;
  }
  member->layout = sft_keep_text(reading->file, text);
  free(text);
  rules->list = sft_grown(rules->list, rules->count, sizeof *rules->list);
  rules->places = sft_grown(rules->places, rules->count, sizeof *rules->places);
  rules->list[rules->count] = (struct sft_rule){.member = index, .text = text_of(annotation)};
  rules->places[rules->count++] = annotation;
}

void sft_read_layouts(struct sft_reading* reading, const idl_struct_t* node, struct sft_declaration* result) {
  struct rules rules = {.count = 0};
  size_t index = 0;
  const idl_member_t* member;
  IDL_FOREACH(member, node->members) {
    const idl_annotation_appl_t* annotation = sft_layout_of(&member->node);
    const idl_declarator_t* declarator;
    IDL_FOREACH(declarator, member->declarators) {
      struct sft_member* read = &result->members[index];
      reading->member = read->name;
      if (annotation != NULL) read_layout(reading, annotation, read, index, &rules);
      ++index;
    }
  }
  struct sft_rule_fault fault;
  if (rules.count != 0 && !sft_check_layouts(see, node, rules.list, rules.count, &fault)) {
    reading->member = result->members[rules.list[fault.rule].member].name;
    refuse(reading, rules.places[fault.rule], &fault);
  }
  free(rules.list);
  free(rules.places);
}
