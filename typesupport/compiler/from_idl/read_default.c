#include "read_default.h"

#include <ctype.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "evaluate.h"
#include "memory.h"
#include "read_type.h"

static bool is_collection(const struct sft_type* type) {
  return type->is_sequence || type->dimension_count > 0;
}

static void check_value(struct sft_reading* reading, const struct sft_type* type,
                        const struct sft_value* value) {
  if (!value->is_set) {
    sft_refuse(reading, "the default is no literal of the member's type: give one, idlc keeps no others");
  } else if (sft_is_bitmask(type) && value->natural > sft_greatest_value(type->kind)) {
    sft_refuse(reading, "the default has bits beyond @bit_bound: use less");
  } else if (type->kind == SFT_STRING && type->string_bound != 0 &&
             strlen(value->text) > type->string_bound) {
    sft_refuse(reading, "the default is longer than %" PRIu32 " characters: use a shorter one",
               type->string_bound);
  }
}

// Evaluates a single value, or one element of a collection.
static struct sft_value evaluated(struct sft_reading* reading, const struct sft_type* type, const char* text,
                                  const void* expression) {
  struct sft_value value =
      sft_evaluate(reading, sft_is_bitmask(type) ? SFT_UINT64 : type->kind, text, expression);
  check_value(reading, type, &value);
  return value;
}

// Returns the end of the element that starts at `at`: after its closing quote, or at the next comma or
// bracket.
static const char* end_of_element(const char* at) {
  const char quote = *at;
  if (quote != '\'' && quote != '"') return at + strcspn(at, ",)");
  for (++at; *at != '\0' && *at != quote; ++at) {
    if (*at == '\\' && at[1] != '\0') ++at;
  }
  return *at == quote ? at + 1 : at;
}

// Translates the Python spelling of a value, from `start` to `end`, to IDL. The caller frees the result.
static char* idl_spelling(enum sft_kind kind, const char* start, const char* end) {
  while (end > start && isspace((unsigned char)end[-1])) --end;
  const size_t length = (size_t)(end - start);
  if (length == 4 && strncmp(start, "True", 4) == 0) return strdup("TRUE");
  if (length == 5 && strncmp(start, "False", 5) == 0) return strdup("FALSE");
  char* spelling = sft_resized(NULL, 2 * length + 1);
  char* to = spelling;
  for (const char* at = start; at < end; ++at) {
    const bool is_delimiter = at == start || at + 1 == end;
    if (kind == SFT_STRING && is_delimiter && (*at == '\'' || *at == '"')) {
      *to++ = '"';
    } else {
      if (kind == SFT_STRING && *at == '"' && at[-1] != '\\') *to++ = '\\';
      *to++ = *at;
    }
  }
  *to = '\0';
  return spelling;
}

static void add_element(struct sft_reading* reading, struct sft_member* member, const char* start,
                        const char* end, const void* expression) {
  char* text = idl_spelling(member->type.kind, start, end);
  member->initial_elements =
      sft_grown(member->initial_elements, member->initial_element_count, sizeof *member->initial_elements);
  member->initial_elements[member->initial_element_count++] =
      evaluated(reading, &member->type, text, expression);
  free(text);
}

static void check_count(struct sft_reading* reading, const struct sft_member* member) {
  size_t count = 1;
  for (size_t i = 0; i < member->type.dimension_count; ++i) count *= member->type.dimensions[i];
  const size_t given = member->initial_element_count;
  if (!member->type.is_sequence && given != count) {
    sft_refuse(reading, "the default has %zu elements, the array %zu: give as many", given, count);
  } else if (member->type.bound != 0 && given > member->type.bound) {
    sft_refuse(reading, "the default has more than %" PRIu32 " elements: give less", member->type.bound);
  }
}

// ROS 2 writes defaults of arrays and sequences as the text of a Python tuple: "(1, 2)", "(1,)", "()".
static void read_tuple(struct sft_reading* reading, struct sft_member* member, const char* tuple,
                       const void* expression) {
  const char* at = tuple + strspn(tuple, " ");
  bool is_good = *at == '(';
  if (is_good) ++at;
  while (is_good) {
    at += strspn(at, " ");
    if (*at == ')') break;
    const char* end = end_of_element(at);
    add_element(reading, member, at, end, expression);
    end += strspn(end, " ");
    is_good = !reading->is_refused && (*end == ',' || *end == ')');
    at = *end == ',' ? end + 1 : end;
  }
  if (is_good) {
    check_count(reading, member);
  } else if (!reading->is_refused) {
    sft_refuse(reading, "defaults of arrays and sequences are written as ROS 2 does, as text: \"(1, 2, 3)\"");
  }
}

static void read_lost(struct sft_reading* reading, const void* expression, struct sft_member* member) {
  char* text = sft_source_text(reading, expression);
  if (text == NULL) {
    sft_refuse(reading, "idlc lost this default: write it as a literal, without macros and constants");
  } else if (is_collection(&member->type)) {
    const struct sft_value tuple = sft_evaluate(reading, SFT_STRING, text, expression);
    read_tuple(reading, member, tuple.is_set ? tuple.text : "", expression);
  } else {
    member->initial = evaluated(reading, &member->type, text, expression);
  }
  free(text);
}

void sft_read_default(struct sft_reading* reading, const idl_member_t* node, struct sft_member* member) {
  const struct sft_type* type = &member->type;
  const bool is_lost = idl_is_alias(node->type_spec) || idl_is_sequence(node->type_spec);
  if (type->kind == SFT_STRUCTURE) {
    sft_refuse(reading, "defaults of structs are not supported: give them to the struct's members");
  } else if (type->name != NULL && !sft_is_bitmask(type)) {
    sft_refuse(reading, "defaults of enumerations are not supported: mark one as @default_literal");
  } else if (is_lost) {
    read_lost(reading, node->value.value, member);
  } else if (is_collection(type)) {  // an array without typedef: idlc takes no text for it
    sft_refuse(reading, "defaults of arrays need a typedef of the array: \"(1, 2, 3)\" is then the default");
  } else {
    member->initial = sft_read_value(type, node->value.value);
    check_value(reading, type, &member->initial);
  }
}
